"""What an empty tool may turn over in a bin: every condition is the verifier's own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.geometry import rotation_rpy
from pickcli.motion.plan import Plan
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.planning.topple import TopplingQuery, plan_topple
from pickcli.scene.scene import Scene
from pickcli.scene.unknown_space import UnknownSpace
from pickcli.verification.push_check import HEAVIEST
from pickcli.verification.topple_check import check_topple
from pickcli.verification.verify import verify
from support.on_edge import APART, BALL, BIN, BRUSH, CELL, ball, on_edge, shelf

HOME = CELL.configurations["home"]
SCENE = shelf(on_edge(), ball(0.2, 0.22))


@pytest.fixture(scope="module")
def plan() -> Plan:
    query = TopplingQuery(BIN, BRUSH)
    return plan_topple(PlanningContext(CELL), SCENE, query, Start(HOME.q, HOME.tool_state))


def checked(plan: Plan, scene: Scene) -> str:
    return "; ".join(map(str, check_topple(plan, scene)))


def test_the_plan_is_accepted(plan: Plan) -> None:
    assert verify(plan, SCENE).reasons == () and not checked(plan, SCENE)


def test_what_reaches_out_of_the_mouth_stays(plan: Plan) -> None:
    assert "mm out of" in checked(plan, shelf(on_edge(x=0.15)))


def test_what_is_heavy_or_carries_others_stays(plan: Plan) -> None:
    brush, other = on_edge(), ball(0.2, 0.22)
    heavy = replace(brush, item=replace(brush.item, mass=HEAVIEST))
    assert "kg, at most" in checked(plan, shelf(heavy))
    T = other.T_world_item.copy()
    T[:3, 3] = brush.T_world_item[:3, 3]
    T[2, 3] += (brush.item.shape.extents[1] + other.item.shape.extents[2]) / 2 + APART
    assert f"{BALL} rests or leans on it" in checked(plan, shelf(brush, replace(other, T_world_item=T)))


def test_only_one_item_turns_over_and_in_a_known_bin(plan: Plan) -> None:
    both = replace(
        plan, segments=tuple(replace(s, pushing=(BRUSH, BALL) if s.pushing else ()) for s in plan.segments)
    )
    assert "only one item turns over at a time" in checked(both, SCENE)
    thing = np.array([[[0.1, -0.1, 0.0], [0.11, -0.09, 0.01]]])
    T = SCENE.T_world_place(CELL.places[BIN])
    unknown = replace(SCENE, unknown=(UnknownSpace(BIN, T, np.zeros((0, 2, 3)), thing),))
    assert "nobody recognised what is at" in checked(plan, unknown)


def test_a_push_inwards_or_outwards_is_refused(plan: Plan) -> None:
    """As the same push is in a pod that stands turned by 15 degrees about the middle of the bin."""
    middle, turn = SCENE.find(BRUSH).T_world_item[:3, 3], np.eye(4)
    turn[:3, :3] = rotation_rpy(0.0, 0.0, np.radians(15.0))
    turn[:3, 3] = middle - turn[:3, :3] @ middle
    turned = replace(SCENE, T_world_pod=turn @ SCENE.T_world_pod)
    assert "pushes inwards or outwards" in checked(plan, turned)
