"""Surfaces by how depth sensors see them."""

from __future__ import annotations

from enum import StrEnum


class Material(StrEnum):
    """Kinds of surfaces."""

    MATTE = "matte"
    DARK = "dark"  # gives little light back
    CLEAR = "clear"  # mostly seen through
    MESH = "mesh"  # of wires or net
    SHINY = "shiny"  # mirrors
