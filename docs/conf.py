"""Sphinx configuration: `make docs` builds the site into build/docs."""

from __future__ import annotations

import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))

project = "apc"
author = "The apc authors"
copyright = author

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_click",
    "api_pages",
]
exclude_patterns = ["_templates"]
source_suffix = {".md": "markdown"}
html_theme = "furo"
html_title = "apc"
html_static_path: list[str] = []
toc_object_entries = (
    False  # every page copies the contents of all others: minutes with classes and methods in them
)
pygments_style = "friendly"
smartquotes = False  # two dashes begin an option
# Attributes of different classes share a name, such as `n`, and docstrings name them without their class.
suppress_warnings = ["ref.python"]

myst_enable_extensions = ["colon_fence", "deflist"]
myst_heading_anchors = 4

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_type_aliases = {"Array": "Array"}
autodoc_default_options = {"members": True, "exclude-members": "model_config"}
napoleon_google_docstring = True
napoleon_numpy_docstring = False
napoleon_use_ivar = True
napoleon_use_rtype = False
