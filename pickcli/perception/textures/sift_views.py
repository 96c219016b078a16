"""How prints are looked for: options that are named without OpenCV."""

from __future__ import annotations

from enum import StrEnum


class SiftViews(StrEnum):
    """Which views of a model features are compared with at once."""

    ALL = "all-views"
    EACH = "each-view"


class SiftRule(StrEnum):
    """For which items prints are looked for, and how."""

    AUTO = "auto"  # as the item and the camera say
    NONE = "none"  # for none
    ALL = "all-views"  # for all that are printed
    EACH = "each-view"
