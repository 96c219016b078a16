"""A browser for tests of pages: the one that is there or can be installed; without one they are skipped."""

from __future__ import annotations

import pytest

from support.browser import find_browser


@pytest.fixture(scope="session")
def chromium() -> str:
    """Path of the browser."""
    found = find_browser()
    if found is None:
        pytest.skip("no Chromium is here, and none can be installed by apt-get: pages are not opened")
    return found
