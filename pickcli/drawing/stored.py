"""Pictures of stored roadmaps and trajectory databases."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from pickcli.cell.cell import Cell
from pickcli.cell.pod_tolerance import PodPoses
from pickcli.drawing.picture import Colour, Coverage, CoverageBar, DrawnLine, Picture
from pickcli.drawing.scenery import arm_solids, node, skeleton, solids, tool_path
from pickcli.kinematics.arm import Arm
from pickcli.precompute.critical_pairs import critical_pairs
from pickcli.roadmap.database_tables import Missing
from pickcli.roadmap.edge_disjoint import edge_disjoint
from pickcli.roadmap.graph import Roadmap
from pickcli.roadmap.roadmap_tables import RoadmapGaps
from pickcli.roadmap.trajectory_database import TrajectoryDatabase

NamePair = tuple[str, str]

_ANY_POD = ("free for any displaced pod", Colour.GOOD)
_NOMINAL = ("free for the pod in its place", Colour.FAIR)


def roadmap_picture(cell: Cell, roadmap: Roadmap, gaps: RoadmapGaps) -> Picture:
    """Draw a roadmap: edges as paths of the tip; per bin the number of important pairs with a second route.

    Args:
        cell: The cell.
        roadmap: The roadmap.
        gaps: Pairs without an edge or second route.

    Returns:
        The picture.
    """
    arm = Arm(cell.robot)
    lines = [
        DrawnLine(
            tool_path(roadmap.edge_path(m), arm), _ink(validity.pod_poses), " to ".join(_names(roadmap, m))
        )
        for m, validity in enumerate(roadmap.validities)
    ]
    outcomes = {pair: _n_routes(roadmap, pair) for pair in critical_pairs(cell)}
    kinds = (("second route", Colour.GOOD), ("one route", Colour.FAIR), ("none", Colour.BAD))
    n_parts = len(set(roadmap.components().tolist()))
    parts = "one part" if n_parts == 1 else f"{n_parts} parts"
    words = (
        f"{roadmap.n_nodes} nodes, {roadmap.n_edges} edges, in {parts}",
        f"{len(gaps.refused)} configurations not free, {len(gaps.missing)} pairs without an edge",
        f"{sum(n == 2 for n in outcomes.values())} of {len(outcomes)} important pairs with a second route",
    )
    return Picture(
        f"Roadmap of {cell.name}", words, (*solids(cell), *arm_solids(cell, arm)),
        (skeleton(cell, arm), *lines),
        tuple(node(cell.configurations[name], arm) for name in roadmap.names if name in cell.configurations),
        Coverage("important pairs of each bin and its camera pose", kinds,
                 _bars(cell, {pair: 2 - n for pair, n in outcomes.items()}.items(), len(kinds))),
        (_ANY_POD, _NOMINAL),
    )  # fmt: skip


def database_picture(cell: Cell, database: TrajectoryDatabase, missing: Sequence[Missing]) -> Picture:
    """Draw a database: motions as paths of the tip; per bin the number of wanted motions that are stored.

    Args:
        cell: The cell.
        database: The stored motions.
        missing: Pairs without a motion, with the reasons.

    Returns:
        The picture.
    """
    arm = Arm(cell.robot)
    lines = [
        DrawnLine(tool_path(motion.path.waypoints, arm), _ink(motion.validity.pod_poses),
             f"{motion.key.start} to {motion.key.goal}, {motion.key.payload}: {motion.duration:.2f} s")
        for motion in database
    ]  # fmt: skip
    stored = [
        ((m.key.start, m.key.goal), 0 if m.validity.pod_poses is PodPoses.DISPLACED else 1) for m in database
    ]
    lost = [((key.start, key.goal), 2) for key, _ in missing]
    kinds = (_ANY_POD, _NOMINAL, ("missing", Colour.BAD))
    total = len(stored) + len(lost)
    words = (
        f"{len(stored)} of {total} wanted motions are stored",
        f"{database.durations.sum():.0f} s in all, {_ratio(database):.3f} times their lower bounds",
    )
    names = dict.fromkeys(name for key in database.keys for name in (key.start, key.goal))
    return Picture(
        f"Trajectory database of {cell.name}", words, (*solids(cell), *arm_solids(cell, arm)),
        (skeleton(cell, arm), *lines),
        tuple(node(cell.configurations[name], arm) for name in names if name in cell.configurations),
        Coverage("motions of each bin and its camera pose", kinds, _bars(cell, [*stored, *lost], len(kinds))),
        (_ANY_POD, _NOMINAL),
    )  # fmt: skip


def _bars(cell: Cell, outcomes: Iterable[tuple[NamePair, int]], n_kinds: int) -> tuple[CoverageBar, ...]:
    """Number of pairs by outcome for each bin, of those that involve the bin or its camera pose."""
    bin_of = _bin_of(cell)
    counts = {name: [0] * n_kinds for name in cell.pod.bins}
    for pair, outcome in outcomes:
        for name in {bin_of[end] for end in pair if end in bin_of}:
            counts[name][outcome] += 1
    return tuple(CoverageBar(name, tuple(kinds)) for name, kinds in counts.items())


def _bin_of(cell: Cell) -> Mapping[str, str]:
    """Bin of each configuration in front of it, and of the camera pose with the same letter."""
    before = (each for each in cell.configurations.values() if each.kind in ("bin", "camera"))
    return {each.name: name for each in before for name in cell.pod.bins if name.endswith(f"_{each.place}")}


def _n_routes(roadmap: Roadmap, pair: NamePair) -> int:
    start, goal = (roadmap.index(name) for name in pair)
    return 0 if start is None or goal is None else len(edge_disjoint(roadmap, start, goal).routes)


def _names(roadmap: Roadmap, edge: int) -> list[str]:
    return [roadmap.names[i] or f"#{i}" for i in roadmap.edges[edge].tolist()]


def _ink(pod_poses: PodPoses) -> Colour:
    return Colour.GOOD if pod_poses is PodPoses.DISPLACED else Colour.FAIR


def _ratio(database: TrajectoryDatabase) -> float:
    bound = float(database.lower_bounds.sum())
    return float(database.durations.sum()) / bound if bound > 0.0 else float("nan")
