"""Expands URDFs written as xacro. The only module that uses the optional package xacro."""

from __future__ import annotations

import multiprocessing
import resource
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from importlib.util import find_spec
from multiprocessing.connection import Connection
from pathlib import Path
from types import ModuleType

from pickcli.errors import InputError
from pickcli.robot_setup.package_search import PackageSearch

_INDEX = "ament_index_python"  # package index used by xacro: part of ROS, in no registry
MOST_TIME = 20  # s of CPU time; real files take well under one
MOST_WAIT = 60.0  # s of wall time
MOST_MEMORY = 2 * 1024**3  # bytes


def expanded(path: Path, packages: PackageSearch, arguments: Mapping[str, str]) -> str:
    """Expand a xacro in a separate process, as its evaluation may not terminate.

    Args:
        path: The file.
        packages: Finder of packages for ``$(find PACKAGE)``.
        arguments: Values of its arguments.

    Returns:
        The URDF as text.

    Raises:
        InputError: The extra is not installed, or xacro fails on the file.
    """
    if find_spec("xacro") is None:
        raise InputError(
            f"{path}: is a xacro, and the package xacro is not installed; pip install 'apc-pick[xacro]', or "
            "expand it where ROS is and name the URDF"
        )
    if not path.is_file():
        raise InputError(f"{path}: no such file; correct the name")
    spawning = multiprocessing.get_context("spawn")
    ours, theirs = spawning.Pipe(duplex=False)
    child = spawning.Process(target=_expand, args=(theirs, path, packages, dict(arguments)), daemon=True)
    child.start()
    theirs.close()
    text, refusal = "", f"more than {MOST_TIME} s or {MOST_MEMORY // 1024**3} GiB to expand it"
    try:
        if ours.poll(MOST_WAIT):
            text, refusal = ours.recv()
    except EOFError:  # killed by the system, e.g. at a resource limit
        pass
    finally:
        child.kill()
        child.join()
    if refusal:
        raise InputError(f"{path}: xacro refuses it: {refusal}")
    return text


def _expand(pipe: Connection, path: Path, packages: PackageSearch, arguments: dict[str, str]) -> None:
    """Send the URDF as text, or the reason for failure. Runs in a process with resource limits."""
    import xacro

    resource.setrlimit(resource.RLIMIT_CPU, (MOST_TIME, MOST_TIME))
    resource.setrlimit(resource.RLIMIT_AS, (MOST_MEMORY, MOST_MEMORY))
    try:
        with _package_index(packages):
            pipe.send((str(xacro.process_file(str(path), mappings=arguments).toprettyxml(indent="  ")), ""))
    except MemoryError:
        pass  # the pipe is closed without an answer
    except Exception as error:  # anything that evaluation of the file may raise
        # Of our own error xacro would tell its class, its text, and its text again.
        inner = getattr(error, "exc", None)
        raised = inner if isinstance(inner, LookupError) else error
        pipe.send(("", str(raised) or type(raised).__name__))


@contextmanager
def _package_index(packages: PackageSearch) -> Iterator[None]:
    """Replace ROS's package index, which xacro imports when a file uses it."""

    def share_directory(name: str) -> str:
        found = packages.find(name)
        if found is None:
            raise LookupError(packages.why_none(name))
        return str(found)

    index, listing = ModuleType(_INDEX), ModuleType(f"{_INDEX}.packages")
    listing.get_package_share_directory = share_directory  # type: ignore[attr-defined]
    ours = {_INDEX: index, listing.__name__: listing}
    before = {name: sys.modules.get(name) for name in ours}
    sys.modules.update(ours)
    try:
        yield
    finally:
        for name, module in before.items():
            if module is None:
                del sys.modules[name]
            else:
                sys.modules[name] = module
