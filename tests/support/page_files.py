"""Pages as their readers find them: the document that an HTML file holds, and its arrays."""

from __future__ import annotations

import base64
import gzip
import json
import re
from typing import Any


def document_of(page: bytes) -> dict[str, Any]:
    """The document in a page."""
    found = re.search(rb'<script id="document"[^>]*>([\w+/=]+)</script>', page)
    assert found is not None
    document: dict[str, Any] = json.loads(gzip.decompress(base64.b64decode(found[1])))
    return document
