"""A package that adds entry points, as it would be installed."""

from __future__ import annotations

from pathlib import Path


def write_package(folder: Path, module: str, text: str, points: dict[str, dict[str, str]]) -> None:
    """Write a module and the metadata of its distribution into a folder of sys.path.

    Args:
        folder: The folder.
        module: Name of the module.
        text: What is in it.
        points: Values of entry points by group and name.
    """
    (folder / f"{module}.py").write_text(text)
    info = folder / f"{module}-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {module}\nVersion: 1.0\n")
    lines = [
        line
        for group, named in points.items()
        for line in (f"[{group}]", *(f"{name} = {value}" for name, value in named.items()))
    ]
    (info / "entry_points.txt").write_text("\n".join(lines) + "\n")
