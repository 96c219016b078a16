"""Candidate sets: the same grasps as arrays and as values."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pickcli.cell.tool import ToolState
from pickcli.errors import Reason
from pickcli.geometry import pose
from pickcli.grasping.grasp_target import CandidateSet, GraspBatch

AGAINST = (Reason("too heavy", "a"),)
scores = st.lists(st.floats(0.0, 9.0), min_size=1, max_size=8)


def batch_of(face: str, scored: list[float]) -> GraspBatch:
    n = len(scored)
    poses = np.array([pose((k, 0.0, 0.0)) for k in range(n)])
    kinds = np.array(["frontal" if k % 2 else "side" for k in range(n)])
    loads = np.arange(5.0 * n).reshape(n, 5)
    return GraspBatch("book", face, ToolState("straight"), kinds, poses, np.array(scored), loads)


@given(scores, scores)
def test_the_grasps_of_all_batches_come_best_first_each_as_in_its_row(
    some: list[float], others: list[float]
) -> None:
    batches = batch_of("-x", some), batch_of("+z", others)
    grasps = CandidateSet(batches, AGAINST).grasps
    assert [g.score for g in grasps] == sorted([*some, *others])
    for grasp in grasps:
        (of,) = (batch for batch in batches if batch.face == grasp.face)
        k = int(grasp.T_item_tip[0, 3])
        assert (grasp.kind, grasp.score) == (of.kinds[k], of.scores[k])
        figures = grasp.moment, grasp.pull, grasp.shear, grasp.twist, grasp.load_ratio
        assert figures == pytest.approx(of.loads[k])


@given(scores, scores, st.integers(0, 2**16))
def test_a_part_and_the_rest_are_all_candidates(some: list[float], others: list[float], bits: int) -> None:
    found = CandidateSet((batch_of("-x", some), batch_of("+z", others)), AGAINST)
    which = [(bits >> 8 * i) >> np.arange(len(b)) & 1 == 1 for i, b in enumerate(found.batches)]
    kept, rest = found.select(which), found.select([~mask for mask in which])
    assert kept.rejected == AGAINST
    assert all(len(b) > 0 for part in (kept, rest) for b in part.batches)
    rows = [(g.face, g.T_item_tip[0, 3]) for part in (kept, rest) for g in part.grasps]
    assert sorted(rows) == sorted((g.face, g.T_item_tip[0, 3]) for g in found.grasps)
