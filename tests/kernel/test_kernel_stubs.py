"""The stubs are those of the kernel as it is built, and everything in it is documented."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

import pickcli.kernel
from pickcli.kernel import _kernel

STUBS = Path(pickcli.kernel.__file__).parent / "_kernel.pyi"


def test_the_stubs_are_current(tmp_path: Path) -> None:
    fresh = tmp_path / "_kernel.pyi"
    subprocess.run(
        [sys.executable, "-m", "nanobind.stubgen", "-q", "-m", "pickcli.kernel._kernel", "-o", str(fresh)],
        check=True,
    )
    assert STUBS.read_text() == fresh.read_text(), "run make stubs"


@pytest.mark.parametrize("name", pickcli.kernel.__all__)
def test_everything_has_a_docstring(name: str) -> None:
    given = getattr(pickcli.kernel, name)
    own = vars(given) if isinstance(given, type) else ()
    members = [getattr(given, member) for member in own if not member.startswith("_")]
    documented = [given, *(member for member in members if not isinstance(member, int))]
    assert all(each.__doc__ and each.__doc__.strip() for each in documented)
    assert getattr(_kernel, name) is given
