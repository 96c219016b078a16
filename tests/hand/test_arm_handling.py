"""An arm takes a can with the hand with belts and sets it down elsewhere, by certified plans and stages."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import pytest

from pickcli.commission.commission_file import read_commission
from pickcli.errors import NoPlanError
from pickcli.geometry import Array, pose
from pickcli.hand.arm_handling import ArmGrasp, ArmHandling
from pickcli.hand.arm_world import ArmWorld
from pickcli.hand.cluster import Cluster
from pickcli.hand.grasp_trial import GraspEnd
from pickcli.hand.pre_grasp_envelope import object_envelopes
from pickcli.hand.staged_execution import StageName
from pickcli.scene.scene import PlacedItem, PoseNoise, Scene
from pickcli.simulation.motion_recorder import MotionRecorder
from pickcli.verification.verify import verify
from support.belt_hands import HAND
from support.commissions import SHIPPED, belts_booth

NOISE = PoseNoise(0.002, float(np.deg2rad(0.5)))


def scene_with(*stand: tuple[str, float, float]) -> Scene:
    """Products of the commission that ships, on the load; the second can is can#2."""
    items = {each.item.name: each.item for each in read_commission(SHIPPED).items}
    cell = belts_booth()
    T = cell.carriers["load"].T_world_carrier
    placed: list[PlacedItem] = []
    for name, x, y in stand:
        item, n = items[name], sum(each.item.name == name for each in placed)
        T_item = T @ pose((x, y, item.shape.extents[2] / 2))
        placed.append(PlacedItem(f"{name}#{n + 1}" if n else name, item, "load", T_item))
    return Scene(cell, cell.T_world_pod, tuple(placed), PoseNoise())


def handling_in(scene: Scene) -> ArmHandling:
    """The arm at home."""
    home = scene.cell.home.q
    masses = {each.id: each.item.mass for each in scene.items}
    return ArmHandling(ArmWorld(scene, HAND, home, masses), home, NOISE, MotionRecorder(), 3)


def seen(handling: ArmHandling) -> Scene:
    """The scene as it is, with the bounds of errors that planning has to bear."""
    return replace(handling.world.now(), noise=NOISE)


@dataclass(frozen=True)
class Handled:
    """A can that was taken and set down."""

    handling: ArmHandling
    grasp: ArmGrasp
    place: Array


@pytest.fixture(scope="module")
def handled() -> Iterator[Handled]:
    handling = handling_in(scene_with(("bull", 0.02, -0.05)))
    world = handling.world
    place = world.cell.carriers["pallet"].T_world_carrier @ pose((0.3, 0.05, 0.135 / 2))
    before = seen(handling)
    can = before.find("bull")
    handling.prepare(can.item.shape)
    handling.approach(before, object_envelopes(HAND, can.item.shape), can.T_world_item)
    grasp = handling.grasp(HAND.objects["bull"], ("bull",))
    handling.transfer(seen(handling), grasp.held, place)
    handling.set_down()
    handling.go_home(seen(handling))
    yield Handled(handling, grasp, place)
    world.close()


@pytest.mark.slow
def test_a_can_is_enveloped_lifted_and_stands_in_its_place_afterwards(handled: Handled) -> None:
    assert handled.grasp.end is GraspEnd.LIFTED and handled.grasp.is_enveloping
    off = handled.handling.world.pose("bull")[:3, 3] - handled.place[:3, 3]
    assert np.hypot(*off[:2]) < 0.02 and abs(off[2]) < 0.001


@pytest.mark.slow
def test_the_stages_are_those_of_the_paper_then_those_of_setting_down(handled: Handled) -> None:
    assert [stage.name for stage in handled.handling.stages] == [
        StageName.OPENING, StageName.CLOSING, StageName.PULL_IN, StageName.FIRM, StageName.LIFT,
        StageName.LOWERING, StageName.OPENING, StageName.BACKING,
    ]  # fmt: skip
    lowering = handled.handling.stages[5]
    assert lowering.ended_by == "contact"


@pytest.mark.slow
def test_every_motion_is_certified_with_what_the_arm_carries_then(handled: Handled) -> None:
    motions = handled.handling.motions
    assert [each.plan.query for each in motions] == ["pre-grasp", "transfer", "home"]
    assert len({each.plan.cell_fingerprint for each in motions}) == 3  # open, around the can, let go
    for each in motions:
        assert each.plan.certificate is not None
        assert verify(each.plan, each.scene).certificate is not None
    names = {body.name for body in motions[1].scene.cell.robot.links[-1].bodies}
    assert "bull" in names and not any(item.id == "bull" for item in motions[1].scene.items)


@pytest.mark.slow
def test_nothing_else_is_touched_no_limit_is_broken_and_the_arm_ends_at_home(handled: Handled) -> None:
    world = handled.handling.world
    assert world.collisions == ()
    assert not any(each.limit_violations or each.stop for each in handled.handling.records)
    assert world.q == pytest.approx(world.cell.home.q, abs=2e-3)


@pytest.mark.slow
def test_an_object_that_others_stand_close_around_has_no_room_for_the_hand() -> None:
    around = [(name, 0.08 * np.cos(a), 0.08 * np.sin(a)) for name, a in
              (("beer", 0.0), ("coke", 1.57), ("box_45", 3.14), ("box_50", 4.71))]  # fmt: skip
    handling = handling_in(scene_with(("bull", 0.0, 0.0), *around))
    before = seen(handling)
    can = before.find("bull")
    handling.prepare(can.item.shape)
    with pytest.raises(NoPlanError, match="pre-grasp"):
        handling.approach(before, object_envelopes(HAND, can.item.shape), can.T_world_item)
    assert handling.motions == []
    handling.world.close()


@pytest.mark.slow
def test_one_can_of_a_cluster_is_lifted_out_and_the_others_stay() -> None:
    triangle = [(0.0, -0.05), (0.0585, -0.05), (0.0292, 0.0007)]
    handling = handling_in(scene_with(*(("coke", x, y) for x, y in triangle)))
    world = handling.world
    before = seen(handling)
    cluster = Cluster.around(before, "coke")
    assert len(cluster.names) == 3
    grasp = handling.grasp_cluster(before, cluster, HAND.objects["coke"])
    assert grasp.end is GraspEnd.LIFTED and grasp.is_enveloping
    (held,) = grasp.held
    others = [name for name in cluster.names if name != held]
    lowest = world.pose(held)[2, 3] - cluster.height / 2
    for name in others:
        T = world.pose(name)
        assert T[2, 2] > 0.999 and T[2, 3] == pytest.approx(before.find(name).T_world_item[2, 3], abs=1e-3)
        assert lowest > T[2, 3] + cluster.height / 2  # clear of them, so that a plan may lead on
    assert [stage.name for stage in grasp.stages][:2] == [StageName.APPROACH, StageName.CLOSING]
    place = world.cell.carriers["pallet"].T_world_carrier @ pose((0.3, 0.05, cluster.height / 2))
    handling.transfer(seen(handling), grasp.held, place)
    handling.set_down()
    assert np.hypot(*(world.pose(held) - place)[:2, 3]) < 0.02
    assert world.collisions == ()
    assert all(verify(each.plan, each.scene).certificate is not None for each in handling.motions)
    world.close()


@pytest.mark.slow
def test_a_cluster_behind_walls_is_refused_with_its_reason() -> None:
    """Boxes stand so close around that the open hand comes in from nowhere."""
    walls = [("box_50", 0.13 * np.cos(a), 0.13 * np.sin(a)) for a in np.arange(12) * np.pi / 6]
    handling = handling_in(scene_with(("bull", -0.027, 0.0), ("bull", 0.027, 0.0), *walls))
    before = seen(handling)
    with pytest.raises(NoPlanError, match="no free pose before the cluster"):
        handling.grasp_cluster(before, Cluster.around(before, "bull"), HAND.objects["bull"])
    assert handling.motions == []
    handling.world.close()
