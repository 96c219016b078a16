"""Pinches of a heavy item: the worse its pose is known, the nearer to its centre it has to be pinched."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import pose
from pickcli.grasping.antipodal import LEAST_SHARE
from pickcli.grasping.grasp_target import CandidateSet, GraspTarget
from pickcli.grasping.pinch_candidates import sample_pinches
from pickcli.grasping.search import USUAL
from pickcli.scene.scene import PoseNoise
from support.gripper_cell import PAD

CAN = Shape(ShapeKind.CYLINDER, (0.0165, 0.0747))


def found(cell: Cell, noise: PoseNoise, mass: float = 1.0) -> CandidateSet:
    """Pinches of a can that stands in the tote."""
    tool, place = cell.robot.tool, cell.places["tote"]
    assert tool.gripper is not None
    item = replace(cell.item("expo_dry_erase_board_eraser"), shape=CAN, mass=mass, mass_error=0.0)
    turn = place.T_place_entry[:3, :3].T
    target = GraspTarget("can", item, pose((0.1, 0.0, 0.0), R=turn), place, noise)
    return sample_pinches(target, tool, tool.gripper, np.random.default_rng(1), USUAL, 0.8)


def lever(candidates: CandidateSet) -> float:
    """M, the longest from the pads to the centre."""
    return max(float(np.linalg.norm(grasp.T_item_tip[:3, 3])) for grasp in candidates.grasps)


def test_what_is_known_worse_is_pinched_deeper_and_loads_no_less(gripper_cell: Cell) -> None:
    exact = found(gripper_cell, PoseNoise())
    noisy = found(gripper_cell, PoseNoise(0.008, np.radians(0.3)))
    half = CAN.extents[2] / 2
    assert lever(exact) == pytest.approx(half - PAD[1] / 2)  # with the pads' edge at the can's
    assert noisy.grasps and lever(noisy) <= half - LEAST_SHARE * PAD[1] / 2 - 0.008
    at = {grasp.T_item_tip.tobytes(): grasp for grasp in exact.grasps}
    for grasp in noisy.grasps:
        assert grasp.load_ratio >= at[grasp.T_item_tip.tobytes()].load_ratio
        assert grasp.moment == at[grasp.T_item_tip.tobytes()].moment


@pytest.mark.parametrize("noise", [PoseNoise(0.02), PoseNoise(0.0, np.radians(3.0))])
def test_what_pads_may_miss_or_meet_askew_is_not_pinched(noise: PoseNoise, gripper_cell: Cell) -> None:
    candidates = found(gripper_cell, noise)
    assert not candidates.grasps
    assert any("see it more exactly" in str(reason) for reason in candidates.rejected)
