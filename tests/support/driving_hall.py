"""A hall for drives of a truck: one rack, a start and a goal with a straight end."""

from __future__ import annotations

HALL = """\
format: apc driving area
version: 1
walls: {low: [0, 0], high: [8, 8]}
boxes:
  - {name: rack, centre: [4, 4], size: [2, 1], yaw: 0.3}
start: {position: [1.5, 1.5], yaw: 0}
goal: {position: [5.5, 1.7], yaw: 0.2, straight: 0.3}
"""
