"""Suggested configurations: what each promises is checked again, and a cell loads with the best."""

from __future__ import annotations

import shutil
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from pickcli.cell.cell_file import load_cell
from pickcli.cell.configuration_text import configuration_line
from pickcli.cell.tool import ToolState
from pickcli.collision.robot_model import CollisionModel
from pickcli.errors import NoPlanError, UnknownNameError
from pickcli.geometry import inverse
from pickcli.kinematics.arm import Arm
from pickcli.planning.planning_context import COARSE_RESERVE
from pickcli.precompute.empty_cell_checkers import checker
from pickcli.reachability.configuration_ranking import ConfigurationRanking
from pickcli.reachability.place_pose_sampling import PlacePoseSampler
from pickcli.reachability.ranked_configuration import RankedConfiguration, RankingSettings
from pickcli.roadmap.trajectory_database import PayloadClass
from support.small_cell import small_cell
from support.tool_states import ALL_STATES, DOWN, STRAIGHT

FEW = RankingSettings(n_places=10, n_kept=8, n_poses=15, seed=2)


@cache
def _found(tool_state: ToolState) -> tuple[RankedConfiguration, ...]:
    found = ConfigurationRanking(small_cell(), "bin_C", tool_state, FEW).suggest(4)
    assert found
    return tuple(found)


@pytest.mark.parametrize("tool_state", [STRAIGHT, DOWN])
def test_they_are_ranked_by_reach_then_manipulability_and_differ(tool_state: ToolState) -> None:
    found = _found(tool_state)
    assert len(found) >= 2
    ranks = [(each.reach, each.manipulability) for each in found]
    assert ranks == sorted(ranks, reverse=True)
    assert found[0].reach > 0.5
    Q = np.stack([each.configuration.q for each in found])
    gaps = np.abs(Q[:, None] - Q[None]).max(axis=2)[np.triu_indices(len(Q), 1)]
    assert gaps.min() > FEW.apart


@pytest.mark.parametrize("tool_state", [STRAIGHT, DOWN])
def test_they_keep_their_distance_from_limits_and_from_everything(tool_state: ToolState) -> None:
    cell = small_cell()
    model, limits = CollisionModel(cell), cell.robot.limits
    for each in _found(tool_state):
        q = each.configuration.q
        shares = np.minimum(q - limits.lower, limits.upper - q) / (limits.upper - limits.lower)
        assert shares.min() == pytest.approx(each.margin) and each.margin >= FEW.margin
        assert each.clearance >= FEW.clearance
        for any_state in ALL_STATES:  # the roadmap takes only what is free in all of them
            assert checker(model, any_state, PayloadClass.EMPTY, FEW.clearance - cell.clearance).is_valid(q)


@pytest.mark.parametrize("tool_state", [STRAIGHT, DOWN])
def test_the_tip_stands_before_the_mouth_and_manipulability_is_sqrt_det_jjt(tool_state: ToolState) -> None:
    cell = small_cell()
    arm = Arm(cell.robot)
    T_world_bin = cell.T_world_place(cell.pod.bins["bin_C"])
    for each in _found(tool_state):
        q = each.configuration.q
        np.testing.assert_allclose(T_world_bin @ each.T_bin_tip, arm.tip(q, tool_state), atol=1e-12)
        assert -0.33 < each.T_bin_tip[0, 3] < -0.09 and abs(each.T_bin_tip[1, 3]) < 0.07
        along = each.T_bin_tip[:3, 2]
        assert along @ ([1, 0, 0] if tool_state == STRAIGHT else [0, 0, -1]) > 0.999
        J = arm.jacobian(q, tool_state)
        J[3:] *= 0.5
        assert each.manipulability == pytest.approx(float(np.sqrt(np.linalg.det(J @ J.T))))


def test_the_same_seed_gives_the_same_and_another_seed_others() -> None:
    def best(seed: int) -> list[float]:
        settings = replace(FEW, n_kept=3, n_poses=5, seed=seed)
        suggester = ConfigurationRanking(small_cell(), "bin_C", STRAIGHT, settings)
        q: list[float] = suggester.suggest(1)[0].configuration.q.tolist()
        return q

    assert best(3) == best(3) != best(4)


def test_a_cell_loads_with_the_best_and_has_it_to_the_last_bit(tmp_path: Path) -> None:
    folder = tmp_path / "cell"
    shutil.copytree(load_cell("apc2016_delft").path, folder)
    best = _found(STRAIGHT)[0].configuration
    path = folder / "cell.yaml"
    lines = path.read_text().splitlines(keepends=True)
    (at,) = [i for i, line in enumerate(lines) if "{name: bin_C, kind: bin" in line]
    path.write_text("".join([*lines[:at], configuration_line(best), *lines[at + 1 :]]))
    adopted = load_cell(folder).configurations["bin_C"]
    assert adopted.q.tobytes() == best.q.tobytes()
    assert (adopted.kind, adopted.tool_state) == ("bin", STRAIGHT)


def test_poses_inside_are_in_the_bin_and_turn_with_the_pod() -> None:
    cell = small_cell()
    each = cell.pod.bins["bin_C"]
    poses = PlacePoseSampler(CollisionModel(cell), each, STRAIGHT)
    T = inverse(poses.T_world_entry) @ poses.inside(np.random.default_rng(0), 200)
    assert T[:, 0, 3].min() > 0.0 and T[:, 0, 3].max() < each.room.depth
    assert T[:, 1, 3].min() > each.room.y_range[0] and T[:, 1, 3].max() < each.room.y_range[1]
    assert T[:, 2, 3].min() > each.room.floor_back and T[:, 2, 3].max() < each.room.ceiling_front
    leans = np.degrees(np.arccos(T[:, 0, 2]))
    assert 25.0 < leans.max() < 43.0


def test_names_and_places_that_are_none_are_refused() -> None:
    with pytest.raises(UnknownNameError, match="unknown place 'bin_Z'"):
        ConfigurationRanking(small_cell(), "bin_Z", STRAIGHT, FEW)
    hopeless = replace(FEW, margin=0.5)
    with pytest.raises(NoPlanError, match=r"in front of bin_C.*nearer than 50% of a range"):
        ConfigurationRanking(small_cell(), "bin_C", STRAIGHT, hopeless).suggest(1)


def test_where_nothing_keeps_so_far_away_what_motions_keep_will_do() -> None:
    cell = small_cell()
    found = ConfigurationRanking(cell, "bin_C", STRAIGHT, replace(FEW, clearance=2.0)).suggest(1)
    assert cell.clearance + COARSE_RESERVE <= found[0].clearance < 2.0
    with pytest.raises(NoPlanError, match=r"of \d+ tried, that keep 2000 and then 6 mm from everything"):
        ConfigurationRanking(cell, "bin_C", STRAIGHT, replace(FEW, clearance=2.0, margin=0.5)).suggest(1)
