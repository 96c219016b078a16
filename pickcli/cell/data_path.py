"""Location of the data folder: beside the package in a checkout, inside it in an installed wheel."""

from __future__ import annotations

from pathlib import Path

import pickcli


def data_path() -> Path:
    """Return the folder that contains cells/, items/ and tasks/.

    Returns:
        Its path.
    """
    package = Path(pickcli.__file__).resolve().parent
    beside = package.parent / "data"
    return beside if (beside / "cells").is_dir() else package / "data"
