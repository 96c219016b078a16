"""Writes a page's document as one HTML file that contains the app, its style, three.js and the data.

The app's modules are concatenated to one script in the order of their imports: ``import`` lines are removed,
and no two modules may declare the same name at top level (checked by a test). So a browser needs no other
file, even if the page is opened from disk.
"""

from __future__ import annotations

import base64
import gzip
import html
import json
import re
from importlib import resources

from pickcli.page.page_document import PageDocument, document_values

MODULES = (  # in the order of their imports
    "data.js", "palette.js", "shapes.js", "robot.js", "stage.js", "cameras.js", "replay.js", "path.js",
    "failures.js", "timeline.js", "panel.js", "main.js",
)  # fmt: skip
THREE = "vendor/three.min.js"
_IMPORT = re.compile(r"^import .*?;\n", re.MULTILINE | re.DOTALL)
_EXPORT = re.compile(r"^export ", re.MULTILINE)


def page_bytes(document: PageDocument) -> bytes:
    """Build a page as one HTML file; equal documents give equal bytes.

    Args:
        document: The document.

    Returns:
        Bytes of the file.
    """
    values = json.dumps(document_values(document), separators=(",", ":"), allow_nan=False, ensure_ascii=False)
    data = base64.b64encode(gzip.compress(values.encode(), compresslevel=9, mtime=0)).decode()
    parts = {
        "TITLE": html.escape(document.title),
        "STYLE": _text("app/style.css"),
        "THREE": _text(THREE),
        "DATA": data,
        "APP": app_script(),
    }
    pieces = re.split(r"\{\{(\w+)\}\}", _text("app/page.html"))
    filled = (parts[piece] if k % 2 else piece for k, piece in enumerate(pieces))
    return "".join(filled).encode()


def app_script() -> str:
    """Build the app as one script.

    Returns:
        JavaScript.
    """
    return "\n".join(
        f"// {name}\n{_EXPORT.sub('', _IMPORT.sub('', _text(f'app/{name}')))}" for name in MODULES
    )


def _text(name: str) -> str:
    return (resources.files("pickcli.page") / name).read_text(encoding="utf-8")
