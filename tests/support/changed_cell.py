"""Cells in which something changed, and the files of a cell, built and refreshed."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from pickcli.cell.cell import Cell
from pickcli.cell.fingerprint import fingerprint
from pickcli.cell.shapes import Body, box
from pickcli.cell.station import Obstacles
from pickcli.geometry import pose
from pickcli.jobs.job_run import RunOptions
from pickcli.precompute.artifact_files import make_roadmap, make_trajectories
from pickcli.precompute.refreshing import Refresh, refresh
from pickcli.roadmap.store import surveyed
from support.small_cell import LEAST_EFFORT
from support.stored_kind import FEW_EDGES


def with_parts(cell: Cell, **parts: object) -> Cell:
    """The cell with some parts replaced, and the fingerprint that it has then."""
    changed = replace(cell, **parts)  # type: ignore[arg-type]
    return replace(changed, fingerprint=fingerprint(changed))


def shifted(body: Body, *by: float) -> Body:
    """A solid that stands elsewhere by x, y, z in m."""
    return replace(body, T_parent_shape=pose(by) @ body.T_parent_shape)


def moved_divider(cell: Cell) -> Cell:
    """One wall between two bins, 10 mm to the side."""
    bodies = tuple(
        shifted(body, 0.0, 0.01, 0.0) if body.name == "row_DEF_divider_left" else body
        for body in cell.pod.bodies
    )
    return with_parts(cell, pod=replace(cell.pod, bodies=bodies))


def new_obstacle(cell: Cell) -> Cell:
    """A post that hangs between home and the tote, in the way of many."""
    post = box("post", (-0.9, -0.36, 1.3), (-0.8, -0.30, 2.0))
    return with_parts(cell, obstacles=Obstacles((*cell.obstacles.bodies, post)))


def no_tote(cell: Cell) -> Cell:
    """Nothing that tote_10h could stand in."""
    assert cell.tote is not None
    return with_parts(cell, tote=replace(cell.tote, bodies=()))


def built(cell: Cell, folder: Path) -> dict[str, bytes]:
    make_roadmap(cell, folder / "edges", FEW_EDGES)
    make_trajectories(cell, folder / "motions", LEAST_EFFORT)
    return {kind: (folder / kind).read_bytes() for kind in ("edges", "motions")}


def refreshed(path: Path, content: bytes, cell: Cell, run_options: RunOptions | None = None) -> Refresh:
    path.write_bytes(content)
    return refresh(path, surveyed(path), cell, run_options)
