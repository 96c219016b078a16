"""Statistics of a stored roadmap or trajectory database."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from pickcli.cell.pod_tolerance import PodPoses
from pickcli.errors import Reason
from pickcli.geometry import Array
from pickcli.roadmap.database_tables import Missing
from pickcli.roadmap.graph import Roadmap
from pickcli.roadmap.roadmap_tables import RoadmapGaps
from pickcli.roadmap.trajectory_database import CoarseMotion, TrajectoryDatabase

N_WORST = 10
NEAR_BOUND = 1.1  # times the bound: largest duration that counts as near it

_RATIOS = (1.0, 1.01, 1.02, 1.05, 1.1, 1.2, 1.5, 2.0, np.inf)


def database_statistics(database: TrajectoryDatabase, missing: Sequence[Missing]) -> dict[str, Any]:
    """Summarise a database: totals, the ten motions farthest from their bounds, a histogram of ratios.

    Motions without a bound (0) are not included in ratios.

    Args:
        database: The motions.
        missing: Motions that the build did not find.

    Returns:
        The figures as JSON values by name.
    """
    motions = [motion for motion in database if motion.lower_bound > 0.0]
    ratios = np.array([motion.duration / motion.lower_bound for motion in motions])
    worst = np.argsort(-ratios, kind="stable")[:N_WORST]
    return {
        "motions": len(database),
        "by_payload": _counts(str(key.payload) for key in database.keys),
        "by_tool_state": _counts(str(tool_state) for tool_state in database.tool_states),
        "by_pod": _counts(str(validity.pod_poses) for validity in database.validities),
        "coverage": round(len(database) / max(len(database) + len(missing), 1), 4),
        "duration_s": round(float(database.durations.sum()), 3),
        "lower_bound_s": round(float(database.lower_bounds.sum()), 3),
        "share_near_bound": round(float(np.mean(ratios <= NEAR_BOUND)), 4) if len(ratios) else None,
        "least_clearance_mm": round(1e3 * float(database.clearances.min()), 1) if len(database) else None,
        "times_its_bound": histogram(ratios, _RATIOS),
        "worst": [_described(motions[k], float(ratios[k])) for k in worst],
        "for_the_nominal_pod_only": [
            f"{key.start} to {key.goal}, {key.payload}: {validity.why_nominal}"
            for key, validity in zip(database.keys, database.validities, strict=True)
            if validity.pod_poses is PodPoses.NOMINAL
        ],
        "missing": [f"{key.start} to {key.goal}, {key.payload}: {reason}" for key, reason in missing],
    }


def roadmap_statistics(roadmap: Roadmap, gaps: RoadmapGaps) -> dict[str, Any]:
    """Summarise a roadmap: totals, the ten longest edges, and a histogram of the nodes' degrees.

    Args:
        roadmap: The roadmap.
        gaps: Gaps that the build left.

    Returns:
        The figures as JSON values; lengths mix m and rad.
    """
    degrees = np.bincount(roadmap.edges.ravel(), minlength=roadmap.n_nodes).tolist()
    worst = np.argsort(-roadmap.lengths, kind="stable")[:N_WORST]
    ends = [[roadmap.names[i] or f"#{i}" for i in edge] for edge in roadmap.edges.tolist()]
    return {
        "nodes": roadmap.n_nodes,
        "edges": roadmap.n_edges,
        "parts": len(set(roadmap.components().tolist())),
        "by_pod": _counts(str(validity.pod_poses) for validity in roadmap.validities),
        "length": round(float(roadmap.lengths.sum()), 3),
        "nodes_by_edges": {f"{n} edges": k for n, k in sorted(Counter(degrees).items())},
        "worst": [f"{' to '.join(ends[m])}: length {roadmap.lengths[m]:.2f}" for m in worst.tolist()],
        "for_the_nominal_pod_only": [
            f"{' to '.join(names)}: {validity.why_nominal}"
            for names, validity in zip(ends, roadmap.validities, strict=True)
            if validity.pod_poses is PodPoses.NOMINAL
        ],
        "refused": [_named(names, reason) for names, reason in gaps.refused],
        "missing": [_named(names, reason) for names, reason in gaps.missing],
        "without_second_route": [_named(names, reason) for names, reason in gaps.without_second_route],
    }


def histogram(values: Array, edges: Sequence[float]) -> dict[str, int]:
    """Count how many values lie in each half-open interval between consecutive edges.

    Args:
        values: (K,) values.
        edges: Bounds of the intervals, increasing; the last may be infinite.

    Returns:
        Counts by the text of the interval, in the order of the edges.
    """
    return {
        f"{low:g} to {high:g}" if np.isfinite(high) else f"{low:g} and more": int(
            np.sum((values >= low) & (values < high))
        )
        for low, high in pairwise(edges)
    }


def _counts(names: Iterable[str]) -> dict[str, int]:
    return dict(sorted(Counter(names).items()))


def _described(motion: CoarseMotion, ratio: float) -> str:
    key = motion.key
    return (
        f"{key.start} to {key.goal}, {key.payload}: {motion.duration:.2f} s, {ratio:.2f} times its bound, "
        f"{1e3 * motion.clearance:.0f} mm clear"
    )


def _named(names: Sequence[str], reason: Reason) -> str:
    return f"{' to '.join(names)}: {reason}"
