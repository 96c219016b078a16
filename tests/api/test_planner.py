"""What scripts call: the same motions as the commands, and one clear error for what is none."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import pickcli
from pickcli import (
    InputError,
    NoPlanError,
    Planner,
    RejectedError,
    StaleError,
    UnknownNameError,
    box,
    make_scene,
)
from pickcli.cell.shapes import Body, Shape, ShapeKind, hull
from pickcli.geometry import Array
from pickcli.motion.plan_file import motion_hash
from support.bare_robot import write_bare_robot
from support.command_line import apc


@pytest.fixture(scope="module")
def planner(tmp_path_factory: pytest.TempPathFactory) -> Planner:
    return Planner.load(write_bare_robot(tmp_path_factory.mktemp("bare")))


BOX = box("box", (-1.15, 0.33, 2.0), (-1.0, 0.6, 2.2))  # where the flange is at home
ASIDE = box("aside", (2.0, 2.0, 0.0), (2.5, 2.5, 1.0))


def test_a_path_is_proven_timed_verified_and_executed(planner: Planner) -> None:
    among = planner.among([ASIDE])
    path = planner.plan_path("home", "away", obstacles=[ASIDE])
    assert (path.start == planner.cell.configurations["home"].q).all()
    np.testing.assert_allclose(path.end, planner.cell.configurations["away"].q)
    plan = among.verify(among.time_path(path))
    assert plan.certificate is not None and plan.cell_fingerprint == among.cell.fingerprint
    assert among.execute(plan).is_clean
    with pytest.raises(StaleError):
        planner.verify(plan)


def test_the_nearest_of_several_goals_is_reached(planner: Planner) -> None:
    near = planner.cell.configurations["home"].q + 0.05
    either: list[str | Array] = ["away", near]
    path = planner.plan_path("home", either)
    np.testing.assert_allclose(path.end, near)
    np.testing.assert_allclose(planner.plan_path("home", near.tolist()).end, near)


def test_a_move_is_the_one_of_the_command(planner: Planner, tmp_path: Path) -> None:
    file = tmp_path / "move.json"
    words = ("--cell", planner.cell.path, "--from", "home", "--to", "away", "-o", file)
    assert apc("plan-move", *words).code == 0
    here = planner.plan_move("home", "away").trajectory
    there = pickcli.read_plan(file).trajectory
    assert (here.positions == there.positions).all() and (here.times == there.times).all()


def test_the_same_seed_gives_the_same_motion(planner: Planner) -> None:
    one, two = (planner.time_path(planner.plan_path("home", "away", seed=3)) for _ in range(2))
    assert motion_hash(one) == motion_hash(two)


def test_what_is_in_the_way_is_named(planner: Planner) -> None:
    with pytest.raises(NoPlanError, match=r"start: collision: .*box"):
        planner.plan_path("home", "away", obstacles=[BOX])
    with pytest.raises(NoPlanError, match=r"goal 0: collision: .*box"):
        planner.plan_path("away", "home", obstacles=[BOX])


def test_a_goal_that_is_not_free_is_left_out(planner: Planner) -> None:
    near = planner.cell.configurations["away"].q + 0.1
    either: list[str | Array] = ["home", near]
    np.testing.assert_allclose(planner.plan_path("away", either, obstacles=[BOX]).end, near)


def test_an_edited_motion_is_rejected_and_does_not_move(planner: Planner) -> None:
    plan = planner.plan_move("home", "away")
    fast = replace(plan.trajectory, velocities=plan.trajectory.velocities * 3.0)
    with pytest.raises(RejectedError):
        planner.execute(replace(plan, trajectory=fast))


def test_mistakes_are_told(planner: Planner) -> None:
    with pytest.raises(UnknownNameError, match="unknown configuration 'hom'; did you mean 'home'"):
        planner.plan_path("hom", "away")
    with pytest.raises(InputError, match="expected 3 numbers"):
        planner.plan_path([0.0, 1.0], "away")
    with pytest.raises(InputError, match="angles are in rad, not degrees"):
        planner.plan_path("home", [0.0, 90.0, 0.0])
    with pytest.raises(InputError, match="no goal is named"):
        planner.plan_path("home", [])
    with pytest.raises(UnknownNameError, match="state of the tool"):
        planner.plan_path("home", "away", tool_state="bent")
    with pytest.raises(InputError, match="'stand': the cell has something of that name"):
        planner.among([box("stand", (0, 0, 0), (1, 1, 1))])
    with pytest.raises(InputError, match="is a hull"):
        planner.among([hull("rock", np.eye(3))])
    with pytest.raises(InputError, match="states no pod"):
        planner.plan_pick(planner.scene, "dove_beauty_bar")


@pytest.mark.parametrize(
    ("solid", "expected"),
    [
        (box("wall", (1, 1, 1), (0, 0, 0)), "a lower corner over the upper one"),
        (box("wall", (np.nan, 0, 0), (1, 1, 1)), "expected the sizes of a box"),
        (box("wall", (0, 0, 0), (1000, 1, 1)), "from 0 to 100 m"),
        (Body("pole", Shape(ShapeKind.CYLINDER, (-0.1, 1.0)), np.eye(4)), "a radius and a length"),
        (Body("ball", Shape(ShapeKind.SPHERE, (0.1, 0.2)), np.eye(4)), "a radius, from 0"),
        (Body("ball", Shape(ShapeKind.SPHERE, (0.1,)), 2 * np.eye(4)), "not a rigid one"),
        ("wall", "expected a Body, got str"),
    ],
)
def test_unsound_obstacles_are_refused(planner: Planner, solid: Body, expected: str) -> None:
    with pytest.raises(InputError, match=expected):
        planner.plan_path("home", "away", obstacles=[solid])


def test_a_box_between_no_corners_is_refused() -> None:
    with pytest.raises(InputError, match="box 'wall': expected two corners"):
        box("wall", (0, 0), (1, 1))  # type: ignore[arg-type]


def test_a_path_of_other_joints_is_refused(planner: Planner) -> None:
    with pytest.raises(InputError, match="path: is of a, b, the cell plans turn, bend"):
        planner.time_path(pickcli.JointPath(("a", "b"), np.zeros((2, 2))))


def test_a_pick_by_region_query_is_dropped_from_over_the_rim() -> None:
    planner = Planner.load("apc2016_delft")
    scene = make_scene({"bin_B": ["crayola_24_ct"]}, planner.cell, 2)
    usual = planner.plan_pick(scene, "crayola_24_ct")
    plan = planner.plan_pick(scene, "crayola_24_ct", approach="region", drop_from="rim")
    assert plan.grasp is not None and plan.grasp.envelope and planner.verify(plan, scene).certificate
    assert plan.trajectory.duration < usual.trajectory.duration
    with pytest.raises(UnknownNameError, match="unknown approach 'regions'"):
        planner.plan_pick(scene, "crayola_24_ct", approach="regions")
    with pytest.raises(UnknownNameError, match="unknown drop_from 'above'"):
        planner.plan_pick(scene, "crayola_24_ct", drop_from="above")
