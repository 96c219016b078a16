"""The proven minimum against brute force: every pair at very many times."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import combinations, pairwise

import numpy as np
import pytest

from pickcli.cell.tool import MOVING
from pickcli.geometry import Array, pose
from pickcli.motion.plan import Plan
from pickcli.motion.segment import SegmentKind
from pickcli.scene.scene import PlacedItem, PoseNoise, Scene
from pickcli.verification.broad_phase import Stretches
from pickcli.verification.clearance_check import (
    DISTANCE_CAP,
    MEASUREMENT_TOLERANCE,
    RESOLUTION,
    Clearance,
    _Search,
    check_clearance,
)
from pickcli.verification.exemptions import exemptions
from pickcli.verification.fcl_solids import Solid
from pickcli.verification.forward_kinematics import link_poses
from pickcli.verification.held_pose import pose_in_tool
from pickcli.verification.moving_parts import Fixture, Part, parts, parts_of_segments
from pickcli.verification.pair_distance import FINER, Pair
from pickcli.verification.solid_arrays import SolidArrays
from pickcli.verification.state_sampling import MAX_STEP
from pickcli.verification.static_solids import plan_fixtures
from pickcli.verification.verify import sampled, verify
from support.handmade_plans import CRAYOLA, Builder, cell, make_scene, move_plan, pick, place, solve, tip


def check(plan: Plan, scene: Scene) -> Clearance:
    T_tip_item = pose_in_tool(plan, scene)
    moving = parts_of_segments(plan, scene, T_tip_item)
    world = plan_fixtures(plan, scene, T_tip_item)
    states = sampled(plan, scene, moving)
    return check_clearance(plan, states, moving, world, exemptions(plan, scene, states, moving, world))


def proven(plan: Plan, scene: Scene) -> float:
    found = check(plan, scene)
    assert found.reasons == ()
    return found.minimum


def brute_force(plan: Plan, scene: Scene, only: range, dt: float = 0.06) -> float:
    """Smallest distance over every pair that is not exempt, dt apart and finely around the nearest state.

    No sieve, no bounds.
    """
    smallest = DISTANCE_CAP
    for k in only:
        segment = plan.segments[k]
        coarse = np.linspace(segment.t_start, segment.t_end, int((segment.t_end - segment.t_start) / dt) + 2)
        near = coarse[np.argmin(found := distances(plan, scene, k, coarse))]
        fine = np.clip(np.linspace(near - dt, near + dt, 20), segment.t_start, segment.t_end)
        smallest = min(smallest, *found, *distances(plan, scene, k, fine))
    return smallest


def distances(plan: Plan, scene: Scene, k: int, times: Array) -> list[float]:
    """The smallest distance at each time of segment k."""
    T_tip_item = pose_in_tool(plan, scene)
    all_moving = parts_of_segments(plan, scene, T_tip_item)
    standing_there = plan_fixtures(plan, scene, T_tip_item)
    states = sampled(plan, scene, all_moving)
    exempt = exemptions(plan, scene, states, all_moving, standing_there)[k]
    moving, world = parts(scene, plan.segments[k], T_tip_item), standing_there.of(k)
    pairs: list[tuple[Part, Part | Fixture]]
    pairs = [(a, b) for a in moving for b in world if not exempt.is_world_pair_untested(a, b.name)]
    pairs += [(a, b) for a, b in combinations(moving, 2) if not exempt.is_own_pair_untested(a, b)]
    links = link_poses(scene.cell.robot, plan.trajectory.sample(times))
    smallest = []
    for i in range(len(times)):
        for part in moving:
            part.solid.place(links[part.link, i] @ part.T_link_shape)
        smallest.append(min(a.solid.distance(b.solid) for a, b in pairs))
    return smallest


def assert_tight(proven_minimum: float, measured: float) -> None:
    """Never above what brute force finds, and not much below."""
    assert proven_minimum <= measured + 1e-6
    assert proven_minimum >= measured - MAX_STEP / 2 - RESOLUTION - 1e-3


@pytest.mark.parametrize("seed", range(6))
def test_random_moves(seed: int) -> None:
    """Between random configurations among boxes that just leave the ends free."""
    rng = np.random.default_rng(seed)
    names = ["bin_A", "bin_E", "bin_I", "bin_K", "home", "tote", "midway", "cam_F"]
    a, b = (cell().configurations[n].q for n in rng.choice(names, 2, replace=False))
    builder = Builder(a)
    builder.joint(SegmentKind.TRANSIT, b, 2.0)
    scene = make_scene(
        place("kleenex_tissue_box", tuple(rng.uniform((-0.7, -0.4, 1.0), (-0.3, 0.4, 1.5))), "bin_A")
    )
    plan = move_plan(scene, builder)
    found = check(plan, scene)
    measured = brute_force(plan, scene, range(1))
    assert found.minimum <= measured + 1e-6
    assert (found.minimum <= 0.0) == bool(found.reasons)
    if not found.reasons and found.minimum < DISTANCE_CAP - MAX_STEP:
        assert_tight(found.minimum, measured)


def test_nothing_is_nearer_between_two_states_than_the_minimum_says() -> None:
    """The cup passes a ball beside its way, and is nearest to it somewhere between two states."""
    q, ball = cell().configurations["home"].q, cell().item("rawlings_baseball")
    aside = float(ball.shape.extents[0]) / 2 + cell().robot.tool.cup.radius + 0.010
    scene = make_scene(PlacedItem("ball", ball, "bin_A", tip(q) @ pose((0.0783, aside, -0.005))))
    builder = Builder(q)
    builder.line(SegmentKind.TRANSIT, tip(q) @ pose((0.16, 0.0, 0.0)), 1.0)
    plan = move_plan(scene, builder)
    times = np.linspace(0.0, 1.0, 41)
    for _ in range(3):
        found = distances(plan, scene, 0, times)
        times = times[np.argmin(found)] + np.linspace(-1.0, 1.0, 41) * (times[1] - times[0])
    assert min(found) < 0.011
    assert min(found) - MAX_STEP / 2 - RESOLUTION <= proven(plan, scene) <= min(found)


def test_the_lines_of_a_pick() -> None:
    """From the approach to the retreat, where clearance is smallest."""
    plan, scene = pick()
    kinds = [s.kind for s in plan.segments]
    span = range(kinds.index(SegmentKind.APPROACH), kinds.index(SegmentKind.RETREAT) + 1)
    measured = brute_force(plan, scene, span)
    assert_tight(proven(plan, scene), measured)


def test_an_item_that_was_taken_is_not_an_obstacle_any_more() -> None:
    plan, scene = pick()
    held = [k for k, s in enumerate(plan.segments) if s.held is not None]
    world = plan_fixtures(plan, scene, pose_in_tool(plan, scene))
    stands = [CRAYOLA in {f.name for f in world.of(k)} for k in range(len(plan.segments))]
    assert stands == [k < held[0] for k in range(len(plan.segments))]


def test_the_arm_may_not_touch_itself() -> None:
    """The forearm folded back onto the upper arm, and the lance turned onto the base."""
    builder = Builder(cell().configurations["home"].q)
    folded = builder.q.copy()
    folded[4], folded[6] = -2.26, -1.9
    builder.joint(SegmentKind.TRANSIT, folded, 2.0)
    scene = make_scene()
    plan = move_plan(scene, builder)
    found = check(plan, scene)
    links = {link.name for link in cell().robot.links}
    assert any(all(n in links for n in r.detail.split(" at ")[0].split(" and ")) for r in found.reasons)


def test_the_moving_cup_covers_both_states() -> None:
    """The angles that are checked while the cup turns reach from state to state without a gap."""
    builder = Builder(cell().configurations["bin_H"].q)
    builder.wait(SegmentKind.TRANSIT, 0.4, tool_state=MOVING)
    scene = make_scene()
    cups = [p for p in parts(scene, builder.segments[0], None) if p.is_cup]
    assert len(cups) > 10
    # neighbouring angles leave no gap wider than the slack on either side
    far = [c.T_link_shape @ np.array([0.015, 0.0, 0.015, 1.0]) for c in cups]
    steps = [np.linalg.norm(p - q) for p, q in pairwise(far)]
    assert max(steps) / 2 <= cups[0].slack + 1e-9


@pytest.mark.parametrize(("apart", "is_accepted"), [(0.0027, False), (0.0033, True)])
def test_the_clearance_of_the_cell_is_kept_as_it_is_stated(apart: float, is_accepted: bool) -> None:
    """A box beside the lance, which stands still: nearer than the clearance is too near, touching or not."""
    builder = Builder(cell().configurations["bin_H"].q)
    builder.wait(SegmentKind.TRANSIT, 0.5)
    empty = make_scene()
    box = place("kleenex_tissue_box", (0.0, 0.0, 0.0), "bin_H")
    near = np.array([-0.3, 0.0, 0.0])
    tip = link_poses(cell().robot, builder.q[None])[-1, 0, :3, 3]
    for _ in range(30):  # towards the tool until it is as near as wanted
        scene = make_scene(replace(box, T_world_item=pose(tip + near)))
        plan = move_plan(scene, builder)
        smallest = min(distances(plan, scene, 0, np.array([0.0])))
        if smallest > 0.0 and abs(smallest - apart) < 1e-6:
            break
        near = near + np.array([smallest - apart, 0.0, 0.0]) if smallest > 0.0 else near * 1.1
    assert abs(smallest - apart) < 1e-6
    verdict = verify(plan, scene)
    assert (verdict.certificate is not None) is is_accepted, verdict.reasons
    assert is_accepted or [r.what for r in verdict.reasons] == ["too close"]
    assert verify(move_plan(empty, builder), empty).certificate is not None


def test_between_states_that_do_not_prove_the_clearance_more_are_looked_at() -> None:
    """A plan that passes at 3.3 mm: no two neighbouring states, 2 mm apart, prove 3 mm by themselves."""
    plan, scene = pick()
    states = sampled(plan, scene, parts_of_segments(plan, scene, pose_in_tool(plan, scene)))
    i = int(np.argmax(np.diff(states.travel.sum(axis=1))))
    finer = states.finer(i, 16)
    assert finer.times[0] == states.times[i] and finer.times[-1] == pytest.approx(states.times[i + 1])
    np.testing.assert_allclose(finer.Q[[0, -1]], states.Q[[i, i + 1]], atol=1e-12)
    way = states.travel[i + 1] - states.travel[i]
    assert (finer.travel[-1] <= way + 1e-9).all()
    assert np.diff(finer.travel.sum(axis=1)).max() < 0.25 * way.sum()


@cache
def near_pairs() -> tuple[tuple[Pair, ...], Plan]:
    """The lance among the walls of a bin, before a box of uncertain pose: its pairs that are near, apart.

    All joints move a little, then the rail alone, there and back.
    """
    front = cell().configurations["bin_H"].q
    start = solve(pose((0.4, 0.0, 0.0)) @ tip(front), front)
    builder = Builder(start)
    builder.joint(SegmentKind.TRANSIT, start + np.array([5, -20, 20, 20, -20, 30, 30, 50]) * 1e-3, 1.0)
    turned = builder.q
    builder.joint(SegmentKind.TRANSIT, turned + 0.02 * np.eye(len(start))[0], 1.0)
    builder.joint(SegmentKind.TRANSIT, turned, 1.0)
    ahead = tip(turned)[:3, 3] + cell().item("kleenex_tissue_box").shape.extents * [0.5, 0.0, 0.0]
    box = place("kleenex_tissue_box", (ahead[0] + 0.04, ahead[1], ahead[2]), "bin_H")
    scene = make_scene(box, noise=PoseNoise(0.002))
    plan = move_plan(scene, builder)
    moving, world = parts_of_segments(plan, scene, None)[0], plan_fixtures(plan, scene, None).of(0)
    states = sampled(plan, scene, [moving])
    pairs = [Pair(0, a, b, states, a.reach) for a in moving for b in world]
    arrays = SolidArrays.of(moving)
    i, j = np.triu_indices(len(moving), 1)
    reaches = arrays.relative_reach(i, j)
    own = zip(i.tolist(), j.tolist(), reaches, strict=True)
    pairs += [Pair(0, *arrays.pair(a, b), states, reach) for a, b, reach in own]
    return tuple(p for p in pairs if 0.0 < p.distance(0) < 0.1 and p.travel[-1] > 0.01), plan


def smallest_between(pair: Pair, t_start: float, t_end: float) -> float:
    """Smallest distance in m at many times, whatever the states; less what may be outside of the shapes."""
    times = np.linspace(t_start, t_end, 3 * FINER + 1)
    links = link_poses(cell().robot, pair.states.trajectory.sample(times))
    found = []
    for i in range(len(times)):
        for part in (pair.a, pair.b):
            if isinstance(part, Part):
                part.solid.place(links[part.link, i] @ part.T_link_shape)
        found.append(pair.a.solid.distance(pair.b.solid))
    return max(0.0, min(found) - pair.a.slack - pair.b.slack)


def test_no_distance_between_two_states_is_below_their_bound() -> None:
    """Nor is the bound farther below the nearer of the two than half of what the pair moves in between."""
    pairs, _ = near_pairs()
    assert any(p.b.slack > 0.0 for p in pairs) and any(isinstance(p.b, Part) for p in pairs)
    rng = np.random.default_rng(0)
    for pair in pairs:
        times = pair.states.times
        for n in (1, 4, 16, 64):
            i = int(rng.integers(len(times) - n))
            bound, way = pair.bound(i, i + n), pair.travel[i + n] - pair.travel[i]
            assert bound <= smallest_between(pair, times[i], times[i + n]) + MEASUREMENT_TOLERANCE
            assert bound >= min(pair.distance(i), pair.distance(i + n)) - way / 2 - 1e-9


def test_what_was_measured_around_a_stretch_bounds_what_lies_in_it() -> None:
    """From one side as from both; and next to a state that was measured by no more than the pair moves."""
    pairs, _ = near_pairs()
    rng = np.random.default_rng(1)
    for pair in pairs:
        n = len(pair.states.times)
        fresh = Pair(pair.segment, pair.a, pair.b, pair.states, pair.reach)
        assert fresh.known(0, n - 1) == -np.inf
        for k in sorted(rng.choice(np.arange(n // 4, 3 * n // 4), 5, replace=False).tolist()):
            fresh.distance(k)
            for i in rng.integers(n - 1, size=10).tolist():
                j = int(min(n - 1, i + rng.integers(1, 20)))
                smallest = min(pair.distance(m) for m in range(i, j + 1))
                assert fresh.known(i, j) <= smallest + MEASUREMENT_TOLERANCE
            way = pair.travel[k + 1] - pair.travel[k]
            assert fresh.known(k, k + 1) >= fresh.distance(k) - way - 1e-12


def test_a_bound_is_reached_by_what_moves_straight_there_and_back() -> None:
    """No higher bound would hold of all motions: the rail takes the lance straight to the box and back."""
    pairs, plan = near_pairs()
    states = pairs[0].states
    i, j = states.between(plan.segments[1].t_start, plan.segments[2].t_end)
    spare = [
        smallest_between(p, states.times[i], states.times[j]) - p.bound(i, j)
        for p in pairs
        if not isinstance(p.b, Part)
    ]
    assert abs(min(spare)) < MEASUREMENT_TOLERANCE


def test_what_is_looked_at_more_finely_proves_more() -> None:
    """The finer bound is below every distance, and nearer to the smallest by about as much as it is finer."""
    pairs, _ = near_pairs()
    rng = np.random.default_rng(0)
    for pair in pairs:
        for i in rng.integers(len(pair.states.times) - 1, size=4).tolist():
            measured, bound = pair.finer(i)
            smallest = smallest_between(pair, pair.states.times[i], pair.states.times[i + 1])
            way = pair.travel[i + 1] - pair.travel[i]
            assert bound <= smallest + MEASUREMENT_TOLERANCE
            assert bound >= smallest - way / FINER - MEASUREMENT_TOLERANCE
            assert smallest <= measured + MEASUREMENT_TOLERANCE
            assert measured <= min(pair.distance(i), pair.distance(i + 1)) + MEASUREMENT_TOLERANCE


def test_a_finer_look_by_gaps_is_below_every_distance_too() -> None:
    """Where gaps do not do, the exact shapes are asked."""
    pairs, plan = near_pairs()
    rng, nothing = np.random.default_rng(2), np.empty(0, dtype=np.int64)
    none = Stretches(np.empty(0), *(nothing for _ in range(5)))
    for needed in (0.0, DISTANCE_CAP):
        for pair in pairs:
            search = _Search(plan, pair.states, SolidArrays.of((pair.a, pair.b)), none, needed)
            i = int(rng.integers(len(pair.states.times) - 1))
            near, low = search._finer(pair, i)
            smallest = smallest_between(pair, pair.states.times[i], pair.states.times[i + 1])
            assert low <= near + MEASUREMENT_TOLERANCE and low <= smallest + MEASUREMENT_TOLERANCE
            assert near <= min(pair.distance(i), pair.distance(i + 1)) + MEASUREMENT_TOLERANCE
            if low < needed:
                assert (near, low) == pytest.approx(pair.finer(i), abs=MEASUREMENT_TOLERANCE)


def test_a_pair_that_stays_as_near_is_measured_rarely(monkeypatch: pytest.MonkeyPatch) -> None:
    """One exact distance bounds all states around it: they are not asked about one by one."""
    q = cell().configurations["home"].q
    builder = Builder(q)
    builder.joint(SegmentKind.TRANSIT, q + 1.5 * np.eye(len(q))[-1], 2.0)
    scene = make_scene()
    plan, asked = move_plan(scene, builder), list[float]()
    exact = Solid.distance

    def counted(self: Solid, other: Solid) -> float:
        asked.append(exact(self, other))
        return asked[-1]

    monkeypatch.setattr(Solid, "distance", counted)
    found = check(plan, scene)
    assert found.reasons == () and found.minimum <= min(asked)
    assert 0 < len(asked) < 200
