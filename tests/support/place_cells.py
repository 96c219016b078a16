"""Copies of the default cell with places of its own: crates on the table, a rack, a bench."""

from __future__ import annotations

from support.cell_copies import CellCopy

TOTE = """tote:
  inner: {lower: [-1.315, -0.796, 0.580], upper: [-0.776, -0.437, 0.781]}  # clear inside; z: floor to rim
  wall_thickness: 0.003
  flange: {lower: [-1.354, -0.804, 0.751], upper: [-0.737, -0.428, 0.781]}  # the outer edge of the rim
"""
CRATES = """places:
  crate_left: {kind: box, T_world_place: {xyz: [-0.9, -0.62, 0.58], rpy: [0, 0, 0.2]}, inner: [0.3, 0.24, 0.14], wall_thickness: 0.006}
  crate_right: {kind: box, T_world_place: {xyz: [-1.25, -0.62, 0.58], rpy: [0, 0, 0]}, inner: [0.3, 0.28, 0.14], wall_thickness: 0.006}
"""  # noqa: E501
RACK = """  rack: {kind: grid, T_world_place: {xyz: [-0.35, 0.62, 0.9], rpy: [0, 0, 0.9]}, rows: [0.25, 0.28], columns: [0.3, 0.26], depth: 0.35, board_thickness: 0.01, wall_thickness: 0.008, lip: {height: 0.015, depth: 0.01}, floor_slope: 0.06}
"""  # noqa: E501
BENCH = """  bench: {kind: table, T_world_place: {xyz: [-0.55, -1.0, 0.75], rpy: [0, 0, 0.1]}, size: [0.5, 0.4, 0.03], displacement: {x: 0.03, yaw: 0.02}}
"""  # noqa: E501
NICHE = """  niche:
    kind: bodies
    T_world_place: {xyz: [-0.3, 1.4, 0.8], rpy: [0, 0, 0]}
    bodies:
      - {name: niche_floor, box: [0.4, 0.5, 0.02], xyz: [0.2, 0, -0.01]}
      - {name: niche_left, box: [0.4, 0.02, 0.4], xyz: [0.2, 0.26, 0.2]}
      - {name: niche_post, cylinder: [0.02, 0.4], xyz: [0.2, -0.27, 0.2]}
    room: {lower: [0, -0.25, 0], upper: [0.4, 0.25, 0.4]}
    access: front
    support: [niche_floor]
"""


def with_places(copy: CellCopy, *parts: str, keep_tote: bool = False) -> CellCopy:
    """The copy with these parts of ``places``, in the stead of the tote unless that is kept."""
    text = "".join(parts)
    copy.yaml.replace(TOTE, TOTE + text if keep_tote else text)
    return copy
