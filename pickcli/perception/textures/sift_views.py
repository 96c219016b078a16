"""Which views of a print model a picture is compared with: an option that is named without OpenCV."""

from __future__ import annotations

from enum import StrEnum

NO_SIFT = "none"  # of the option: prints are not looked for


class SiftViews(StrEnum):
    """Which views of a model features are compared with at once."""

    ALL = "all-views"
    EACH = "each-view"
