"""``apc plan-pick --stream --stream-rule pr2-2013 --grasps``: the filters of 2013, and what they remove."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pickcli.grasping.recorded_grasp import recorded_from_plan
from pickcli.grasping.recorded_grasp_file import write_recorded_grasps
from pickcli.motion.plan import Plan
from pickcli.scene.stream_file import write_stream
from pickcli.verification.verify import certifier
from support.command_line import apc, refused
from support.pr2_picks import arm_pick, context

ITEM = 3  # of the stream


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A stream; a grasp that passes both filters between two that do not; and those two alone."""
    path = tmp_path_factory.mktemp("grasps")
    plan = certifier(arm_pick(k=ITEM).scene)(arm_pick(k=ITEM).plan)
    assert isinstance(plan, Plan)
    good, carrier = recorded_from_plan(plan, context().cell), arm_pick(k=ITEM).stream.carrier
    R = (carrier.T_world_carrier @ arm_pick(k=ITEM).stream.items[ITEM].T_belt_item)[:3, :3]
    behind, far = good.T_item_pregrasp.copy(), good.T_item_pregrasp.copy()
    behind[:3, 3] = good.T_item_grasp[:3, 3] - 0.1 * R.T @ carrier.T_world_carrier[:3, 0]
    far[:3, 3] = good.T_item_grasp[:3, 3] - 0.45 * R.T @ np.eye(3)[2]
    bad = [replace(good, T_item_pregrasp=T, source=name) for T, name in ((behind, "behind"), (far, "far"))]
    write_recorded_grasps([bad[0], good, bad[1]], context().cell, path / "all.json")
    write_recorded_grasps(bad, context().cell, path / "bad.json")
    write_stream(arm_pick(k=ITEM).stream, path / "stream.json")
    return path


def words(folder: Path, grasps: str, *more: object, arm: str | None = "left") -> tuple[object, ...]:
    riding = arm_pick(k=ITEM).stream.items[ITEM]
    asked = ("--item", riding.id, "--now", f"{riding.stamp + 0.3:.3f}", "--into", "bin_left")
    moved = () if arm is None else ("--arm", arm)
    return (
        "plan-pick",
        "--stream",
        folder / "stream.json",
        *asked,
        *moved,
        "--grasps",
        folder / grasps,
        *more,
    )


def test_each_filter_tells_which_grasps_it_removed_and_why(folder: Path, tmp_path: Path) -> None:
    by_rule, plan = ("--stream-rule", "pr2-2013"), tmp_path / "plan.json"
    planned = apc(*words(folder, "all.json", *by_rule, "--planner", "ara-star", "-o", plan))
    assert planned.code == 0 and "certified" in planned.out, planned.err
    assert "recorded grasp 1 (behind): chase filter: it runs after the item, 0 degrees from" in planned.out
    assert "recorded grasp 3 (far): kinematic filter: the arm does not reach its pregrasp" in planned.out
    assert "recorded grasp 2" not in planned.out and "transit by ARA*" in planned.out
    told = json.loads(apc(*words(folder, "all.json", *by_rule, "--json", "-o", tmp_path / "b.json")).out)
    removed = [(each["grasp"], each["source"], each["by"]) for each in told["removed_grasps"]]
    assert removed == [(1, "behind", "chase filter"), (3, "far", "kinematic filter")]
    every = ("--stream-rule", "earliest", "--json", "-o", tmp_path / "d.json")
    assert "removed_grasps" not in json.loads(apc(*words(folder, "all.json", *every)).out)
    earliest = apc(*words(folder, "all.json", "-o", tmp_path / "c.json"))
    assert earliest.code == 0 and "chase filter" not in earliest.out


def test_where_they_leave_no_grasp_there_is_no_plan(folder: Path, tmp_path: Path) -> None:
    none = apc(*words(folder, "bad.json", "--stream-rule", "pr2-2013", "-o", tmp_path / "plan.json"))
    refused(none, 5, "no recorded grasp passes the filters; recorded grasp 1 (behind): chase filter")
    assert "recorded grasp 2 (far): kinematic filter" in none.err
    assert not (tmp_path / "plan.json").exists()


def test_of_several_arms_each_tells_which_grasps_were_removed(folder: Path, tmp_path: Path) -> None:
    by_rule, plan = ("--stream-rule", "pr2-2013"), tmp_path / "plan.json"
    none = apc(*words(folder, "bad.json", *by_rule, "-o", plan, arm=None))
    refused(none, 5)
    for arm in ("left", "right"):
        (line,) = (line for line in none.err.splitlines() if line.startswith(f"  arm {arm}: "))
        assert "no recorded grasp passes the filters; recorded grasp 1 (behind): chase filter: it" in line
        assert "recorded grasp 2 (far): kinematic filter: the arm does not reach its" in line
