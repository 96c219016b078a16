"""URDFs that are written as xacro. The only file that knows xacro, which is an extra."""

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

_INDEX = "ament_index_python"  # where xacro looks for packages: part of ROS, on no registry
MOST_TIME = 20  # s of the processor; real ones take well under one
MOST_WAIT = 60.0  # s, where it waits for something
MOST_MEMORY = 2 * 1024**3  # bytes


def expanded(path: Path, packages: PackageSearch, arguments: Mapping[str, str]) -> str:
    """Expand a xacro, in a process of its own: what it has evaluated may have no end.

    Args:
        path: The file.
        packages: Finds what ``$(find PACKAGE)`` asks for.
        arguments: Values of its arguments.

    Returns:
        The URDF as text.

    Raises:
        InputError: The extra is not installed, or xacro refuses the file.
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
    except EOFError:  # the system ended it
        pass
    finally:
        child.kill()
        child.join()
    if refusal:
        raise InputError(f"{path}: xacro refuses it: {refusal}")
    return text


def _expand(told: Connection, path: Path, packages: PackageSearch, arguments: dict[str, str]) -> None:
    """Tell the URDF as text, or why there is none. Runs in a process that may come to its bounds."""
    import xacro

    resource.setrlimit(resource.RLIMIT_CPU, (MOST_TIME, MOST_TIME))
    resource.setrlimit(resource.RLIMIT_AS, (MOST_MEMORY, MOST_MEMORY))
    try:
        with _package_index(packages):
            told.send((str(xacro.process_file(str(path), mappings=arguments).toprettyxml(indent="  ")), ""))
    except MemoryError:
        pass  # the pipe is closed without an answer
    except Exception as error:  # whatever the file makes xacro evaluate
        told.send(("", str(error) or type(error).__name__))


@contextmanager
def _package_index(packages: PackageSearch) -> Iterator[None]:
    """Answer for ROS's index of packages, which xacro imports when a file asks for one."""

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
