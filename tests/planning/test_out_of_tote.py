"""Out of the tote, which is open above, by the same stages as out of a bin: straight up between the walls."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from pickcli.cartesian.corridor import LEAST_LIP_DISTANCE
from pickcli.cell.cell import Cell
from pickcli.errors import Failures, NoPlanError, UnknownNameError
from pickcli.geometry import inverse, pose, rotation_rpy
from pickcli.motion.segment import SegmentKind
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_problem import PickProblem, PickQuery
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.stages.extraction import extraction_of
from pickcli.planning.start_state import Start
from pickcli.scene.scene import TOTE, PlacedItem, PoseNoise, Scene
from pickcli.simulation.execute import execute
from pickcli.simulation.reality import Reality
from pickcli.simulation.world import World
from pickcli.trial.pose_noise import DEFAULT_NOISE, perceive
from pickcli.verification.verify import certify, verify
from support.tool_states import DOWN, STRAIGHT

CRAYONS, BAR, BOOK = "crayola_24_ct", "dove_beauty_bar", "i_am_a_bunny_book"
InTote = Callable[..., Scene]


@pytest.fixture(scope="module")
def in_tote(cell: Cell) -> InTote:
    """in_tote(("crayola_24_ct", x, y, up), ...): items level in the tote, ``up`` m over its floor."""

    def make(*entries: tuple[str, float, float, float]) -> Scene:
        place, placed = cell.places[TOTE], []
        for name, x, y, up in entries:
            item = cell.item(name)
            z = float(item.shape.extents[2]) / 2 + 0.0005 + up
            placed.append(PlacedItem(name, item, TOTE, cell.T_world_place(place) @ pose([x, y, z])))
        return Scene(cell, cell.T_world_pod, tuple(placed), PoseNoise(0.002, float(np.radians(1.0))))

    return make


def test_the_simulated_robot_takes_it_out(context: PlanningContext, in_tote: InTote, home: Start) -> None:
    scene = in_tote((CRAYONS, 0.1, 0.0, 0.0), (BAR, -0.15, 0.0, 0.0))
    plan = certify(plan_pick(context, scene, PickQuery(TOTE, CRAYONS), home), scene)
    world = World(scene, home.q)
    run = execute(plan, world)
    assert run.has_item and not run.stopped
    assert world.placed(CRAYONS).location == TOTE and not world.contacts.collisions
    world.close()


@pytest.mark.parametrize(("x", "y"), [(0.0, 0.0), (0.2, 0.1)])
def test_it_comes_out_upwards_and_is_certified(
    context: PlanningContext, in_tote: InTote, home: Start, x: float, y: float
) -> None:
    scene = in_tote((CRAYONS, x, y, 0.0), (BAR, -0.15, 0.0, 0.0))
    plan = plan_pick(context, scene, PickQuery(TOTE, CRAYONS), home)
    assert verify(plan, scene).reasons == ()
    assert plan.grasp is not None and (plan.grasp.kind, plan.grasp.tool_state) == ("top-down", STRAIGHT)
    kinds = [segment.kind for segment in plan.segments]
    assert kinds[:4] == ["transit", "pre-approach", "approach", "contact"] and "retreat" in kinds
    out = next(s for s in plan.segments if s.kind is SegmentKind.RETREAT)
    a, b = context.arm.tips(plan.trajectory.sample(np.array([out.t_start, out.t_end])), STRAIGHT)[:, :3, 3]
    assert b[2] - a[2] > 0.05
    assert np.linalg.norm((b - a)[:2]) < 0.01


def test_beside_a_wall_it_moves_away_from_it_before_it_rises(
    context: PlanningContext, in_tote: InTote
) -> None:
    item = context.cell.item(CRAYONS)
    x = float(context.cell.places[TOTE].room.size[0] - item.shape.extents[0]) / 2 - 0.002
    scene = in_tote((CRAYONS, x, 0.0, 0.0))
    tote = context.cell.places[TOTE]
    problem = PickProblem(context, scene, tote, scene.find(CRAYONS), tote)
    ways = extraction_of(problem).corridors
    assert not isinstance(ways, Failures) and ways
    for way in ways:
        moved = problem.T_world_entry[:3, :3] @ way.lift[:3]
        assert moved[0] < -0.005 and moved[2] > 0.05


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_what_stands_on_edge_at_a_wall_is_pressed_on_it_and_comes_out(
    context: PlanningContext, cell: Cell, home: Start, seed: int
) -> None:
    """A slender pack would fall over under the cup if the wall did not stop it."""
    name, tote = "womens_knit_gloves", cell.places[TOTE]
    item, low = cell.item(name), tote.room.low
    T = pose(
        (0.05, float(low[1]) + 0.001 + float(item.shape.extents[2]) / 2, float(item.shape.extents[1]) / 2),
        rpy=(np.pi / 2, 0.0, 0.0),
    )
    scene = Scene(
        cell, cell.T_world_pod, (PlacedItem(name, item, TOTE, cell.T_world_place(tote) @ T),), PoseNoise()
    )
    seen = perceive(scene, DEFAULT_NOISE, seed, 1, Reality())
    plan = certify(plan_pick(context, seen, PickQuery(TOTE, name), home), seen)
    assert plan.grasp is not None and plan.grasp.kind != "top-down"
    world = World(scene, home.q)
    run = execute(plan, world)
    assert run.has_item and not run.stopped
    assert not world.contacts.collisions
    world.close()


def test_what_lies_askew_comes_out_although_the_box_around_it_is_wider_than_the_tote(
    context: PlanningContext, cell: Cell
) -> None:
    """A roll that leans across the tote: the corners of that box are empty."""
    name, tote = "kleenex_paper_towels", cell.places[TOTE]
    R = rotation_rpy(0.0, 0.0, np.pi / 2) @ rotation_rpy(0.0, np.radians(65.0), 0.0)
    item, noise = cell.item(name), PoseNoise(0.003, float(np.radians(1.5)))
    reach = item.shape.inflated(noise.bound(item)).reach(R)
    assert 2 * reach[1] > tote.access.width - 2 * LEAST_LIP_DISTANCE
    T = cell.T_world_place(tote) @ pose((0.0, 0.0, 0.08 + float(reach[2])), R=R)
    scene = Scene(cell, cell.T_world_pod, (PlacedItem(name, item, TOTE, T),), noise)
    problem = PickProblem(context, scene, tote, scene.items[0], tote)
    assert not isinstance(extraction_of(problem).corridors, Failures)


def test_what_lies_on_it_is_named(context: PlanningContext, in_tote: InTote, home: Start) -> None:
    scene = in_tote(
        (BOOK, 0.0, 0.0, 0.0), (CRAYONS, 0.0, 0.0, float(context.cell.item(BOOK).shape.extents[2]))
    )
    with pytest.raises(NoPlanError) as caught:
        plan_pick(context, scene, PickQuery(TOTE, BOOK), home)
    assert caught.value.in_the_way == (CRAYONS,)


def test_its_own_place_in_the_tote_is_free_for_it(
    context: PlanningContext, in_tote: InTote, home: Start
) -> None:
    """Alone in the tote it can be let go where it lay: no pile is counted but of what stays there."""
    scene = in_tote((CRAYONS, 0.0, 0.0, 0.0))
    plan = plan_pick(context, scene, PickQuery(TOTE, CRAYONS), home)
    release = [s.t_end for s in plan.segments if s.held is not None][-1]
    assert plan.grasp is not None
    tip = context.arm.tips(plan.trajectory.sample(np.array([release])), STRAIGHT)[0]
    bottom = (tip @ inverse(plan.grasp.T_item_tip))[2, 3] - scene.items[0].item.shape.extents.max() / 2
    assert bottom < context.cell.T_world_place(context.cell.places[TOTE])[2, 3] + 0.06


def test_a_place_that_is_not_there_is_refused(context: PlanningContext, in_tote: InTote, home: Start) -> None:
    with pytest.raises(UnknownNameError, match="bin_Z"):
        plan_pick(context, in_tote((CRAYONS, 0.0, 0.0, 0.0)), PickQuery("bin_Z", CRAYONS), home)


@pytest.mark.parametrize("yaw", [0.3, 2.0])
def test_what_stands_on_edge_is_taken_by_its_side_and_laid_down_in_a_bin(
    context: PlanningContext, cell: Cell, home: Start, yaw: float
) -> None:
    """A box whose upper side is narrower than a cup: the lance comes down beside it, across the cup."""
    name = "command_hooks"
    item = cell.item(name)
    R = rotation_rpy(0.0, 0.0, yaw) @ rotation_rpy(np.pi / 2, 0.0, 0.0)
    T = pose((0.0, 0.0, float(item.shape.extents[1]) / 2 + 0.0005), R=R)
    placed = PlacedItem(name, item, TOTE, cell.T_world_place(cell.places[TOTE]) @ T)
    scene = Scene(cell, cell.T_world_pod, (placed,), PoseNoise(0.002, float(np.radians(1.0))))
    plan = certify(plan_pick(context, scene, PickQuery(TOTE, name, "bin_E"), home), scene)
    assert plan.grasp is not None and plan.grasp.tool_state == DOWN and plan.grasp.face[1] == "z"
    world = World(scene, home.q, home.tool_state)
    run = execute(plan, world)
    world.wait(0.5)
    assert not run.stopped and not world.contacts.collisions
    there = world.placed(name)
    assert there.location == "bin_E" and abs(there.T_world_item[2, 2]) > 0.95
    world.close()
