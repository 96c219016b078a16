"""The way out from where a motion stopped: home, whatever the cup touches, certified."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from pickcli.cell.model import Cell
from pickcli.cell.scene import Scene
from pickcli.geometry import pose
from pickcli.grasping.candidates import sample_grasps
from pickcli.motion.segment import SegmentKind
from pickcli.planning import grasps
from pickcli.planning.context import Planner
from pickcli.planning.pick import Start, plan_pick
from pickcli.planning.recover import plan_recovery
from pickcli.verification.verify import verify

SceneWith = Callable[..., Scene]


@pytest.fixture(scope="module")
def home(cell: Cell) -> Start:
    named = cell.configurations["home"]
    return Start(named.q, named.pivot)


def stopped_at_contact(planner: Planner, scene: Scene, home: Start, bin_name: str, item: str) -> Start:
    plan = plan_pick(planner, scene, bin_name, item, home)
    contact = next(s for s in plan.segments if s.kind is SegmentKind.CONTACT)
    return Start(plan.trajectory.sample(contact.t_end)[0], contact.pivot)


def test_the_way_out_of_a_bin_leads_home(planner: Planner, scene_with: SceneWith, home: Start) -> None:
    scene = scene_with(("crayola_24_ct", "bin_B", 0.25, 0.0))
    out = plan_recovery(planner, scene, stopped_at_contact(planner, scene, home, "bin_B", "crayola_24_ct"))
    np.testing.assert_allclose(out.trajectory.positions[-1], home.q)
    assert out.segments[0].kind is SegmentKind.DEPART
    assert verify(out, scene).reasons == ()


@pytest.mark.parametrize("moved", [0.0, 0.004])
def test_beside_a_tall_item_the_cup_goes_back_first(
    planner: Planner, scene_with: SceneWith, home: Start, monkeypatch: pytest.MonkeyPatch, moved: float
) -> None:
    """Upwards it would scrape along; moved: m that the item has come towards the cup since."""

    def from_the_side(*args: Any) -> Any:
        found = sample_grasps(*args)
        return replace(found, grasps=tuple(g for g in found.grasps if g.kind == "side"))

    monkeypatch.setattr(grasps, "sample_grasps", from_the_side)
    scene = scene_with(("kleenex_tissue_box", "bin_D", 0.2, 0.04))
    stuck = stopped_at_contact(planner, scene, home, "bin_D", "kleenex_tissue_box")
    tip = planner.arm.tip(stuck.q, stuck.pivot)
    (box,) = scene.items
    T = pose(-moved * tip[:3, 2]) @ box.T_world_item
    scene = replace(scene, items=(replace(box, T_world_item=T),))
    out = plan_recovery(planner, scene, stuck)
    np.testing.assert_allclose(out.trajectory.positions[-1], home.q)
    freed = planner.arm.tip(out.trajectory.sample(out.segments[0].t_end)[0], stuck.pivot)
    assert (freed - tip)[:3, 3] @ tip[:3, 2] < -0.015
    assert verify(out, scene).reasons == ()
