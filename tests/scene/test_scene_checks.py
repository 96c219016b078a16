"""What a scene must agree with: bins, floors, solids and the cup, on both sides of each bound."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.pod_tolerance import Displacement
from pickcli.errors import InputError
from pickcli.files.source import Source
from pickcli.geometry import Array, inverse, pose
from pickcli.scene.cloud import Cloud
from pickcli.scene.scene import TOTE, HeldItem, PlacedItem, PoseNoise, Scene
from pickcli.scene.scene_checks import check_floating, check_places
from pickcli.scene.scene_file import read_scene, write_scene
from pickcli.scene.touching import PosedSolids, gaps
from support.scene_files import edit, make_scene, put_at

Refused = Callable[[Callable[[], object]], str]


@pytest.mark.parametrize(
    ("z", "told"),
    [(40.0, "is 40 m from the tip of the cup"), (0.2, "is 0.2 m from the tip"), (-0.04, "into the tool"),
     (-0.3, "is 0.3 m from the tip"), (0.0, "into the tool"), (0.033, ""), (0.03, ""), (0.04, "")],
)  # fmt: skip
def test_what_the_cup_holds_begins_at_its_tip(written: Path, refused: Refused, z: float, told: str) -> None:
    held = {"id": "ball", "name": "rawlings_baseball", "year": 2016, "quaternion": [0, 0, 0, 1]}
    edit(written, put_at("held", value={**held, "position": [0, 0, z]}))
    if told:
        message = refused(lambda: read_scene(written))
        assert "held.position: " in message and told in message and "in the tool frame, in m" in message
    else:
        assert read_scene(written).held is not None


def test_overlapping_items_are_both_named_with_the_depth(written: Path, refused: Refused) -> None:
    def change(content: dict[str, Any]) -> None:
        x, y, z = content["items"][0]["position"]
        content["items"][1].update(location="bin_A", position=[x, y, z + 0.015], quaternion=[0, 0, 0, 1])

    edit(written, change)
    message = refused(lambda: read_scene(written))
    assert "crayola_24_ct#0 and crayola_24_ct#1 overlap by 10.0 mm" in message


def test_stacked_items_that_touch_are_accepted(cell: Cell, tmp_path: Path) -> None:
    scene = make_scene(cell)
    below = scene.items[0]
    above = replace(below, id="above", T_world_item=pose((0, 0, 0.0245)) @ below.T_world_item)
    write_scene(replace(scene, items=(*scene.items, above)), tmp_path / "s.json")
    assert len(read_scene(tmp_path / "s.json").items) == len(scene.items) + 1


def test_an_overlap_within_the_stated_noise_is_no_contradiction(written: Path, refused: Refused) -> None:
    def lower(content: dict[str, Any], noise: float) -> None:
        x, y, z = content["items"][0]["position"]
        content["items"][1].update(location="bin_A", position=[x, y, z + 0.0205], quaternion=[0, 0, 0, 1])
        content["noise"] = {"position": noise, "angle": 0.0}

    edit(written, lambda content: lower(content, 0.002))
    assert len(read_scene(written).items) == 13
    edit(written, lambda content: lower(content, 0.001))
    assert "overlap by 4.5 mm" in refused(lambda: read_scene(written))


def test_an_item_sunk_into_its_floor_is_told_as_such(cell: Cell, written: Path, refused: Refused) -> None:
    scene = make_scene(cell)
    first = scene.items[0]
    write_scene(scene.moved(replace(first, T_world_item=pose((0, 0, -0.03)) @ first.T_world_item)), written)
    message = refused(lambda: read_scene(written))
    assert f"items[0].position: {first.id} reaches 30.0 mm under the floor of bin_A" in message


def test_an_item_in_the_shelf_is_told_as_such(cell: Cell, written: Path, refused: Refused) -> None:
    scene = make_scene(cell)
    first = scene.items[0]
    write_scene(scene.moved(replace(first, T_world_item=pose((0, -0.12, 0)) @ first.T_world_item)), written)
    message = refused(lambda: read_scene(written))
    assert f"items[0].position: {first.id} stands " in message and "mm deep in " in message


@pytest.mark.parametrize(("x", "told"), [(-0.14, "floats: "), (-0.16, "is 0.16 m away from bin_A")])
def test_an_item_may_be_so_far_out_of_its_bin_before_it_counts_as_elsewhere(
    cell: Cell, written: Path, refused: Refused, x: float, told: str
) -> None:
    first = make_scene(cell).items[0]
    T = first.T_world_item.copy()
    T[0, 3] = x
    write_scene(make_scene(cell).moved(replace(first, T_world_item=T)), written)
    (line,) = refused(lambda: read_scene(written)).splitlines()
    assert f"{first.id} {told}" in line


def _read(scene: Scene, path: Path, noise: float = 0.0, pod_error: Displacement | None = None) -> Scene:
    write_scene(replace(scene, noise=PoseNoise(noise, 0.0), pod_error=pod_error or Displacement()), path)
    return read_scene(path)


def _lowered(scene: Scene, item: PlacedItem, *, dz: float = 0.0, dx: float = 0.0, dy: float = 0.0) -> Scene:
    return scene.moved(replace(item, T_world_item=pose((dx, dy, dz)) @ item.T_world_item))


@pytest.mark.parametrize("noise", [0.0, 0.003])
def test_an_item_may_sink_into_its_floor_by_5_mm_and_its_noise(
    cell: Cell, written: Path, noise: float
) -> None:
    scene = make_scene(cell)
    first = replace(
        scene.items[0], T_world_item=cell.pod.bins["bin_A"].T_carrier_place
        @ pose((0.33, 0.0, cell.pod.bins["bin_A"].room.floor_back + scene.items[0].item.shape.extents[2] / 2))
    )  # fmt: skip
    alone = replace(scene, items=(first,))
    assert _read(_lowered(alone, first, dz=-0.0049 - noise), written, noise)
    with pytest.raises(InputError, match=f"reaches {5.1 + 1000 * noise:.1f} mm under the floor of bin_A"):
        _read(_lowered(alone, first, dz=-0.0051 - noise), written, noise)


def _in_tote(cell: Cell, dz: float) -> PlacedItem:
    """A box on the tote's bottom, or deeper."""
    item = cell.item("crayola_24_ct")
    T = cell.places["tote"].T_carrier_place @ pose((0.0, 0.0, float(item.shape.extents[2]) / 2 + dz))
    return PlacedItem("one", item, TOTE, T)


@pytest.mark.parametrize("noise", [0.0, 0.003])
def test_an_item_may_stand_in_the_tote_by_5_mm_and_its_noise(
    cell: Cell, tmp_path: Path, noise: float
) -> None:
    scene, path = make_scene(cell), tmp_path / "tote.json"
    assert _read(replace(scene, items=(_in_tote(cell, -0.0049 - noise),)), path, noise)
    with pytest.raises(InputError, match=r"items\[0\]\.position: one stands .* mm deep in .*tote"):
        _read(replace(scene, items=(_in_tote(cell, -0.0053 - noise),)), path, noise)


def test_where_the_pod_may_stand_elsewhere_an_item_may_stand_deeper(cell: Cell, tmp_path: Path) -> None:
    """By as much as the pod's farthest corner may be off: 3 mm here."""
    scene, path = replace(make_scene(cell), items=(_in_tote(cell, -0.007),)), tmp_path / "tote.json"
    assert _read(scene, path, pod_error=Displacement(0.003, 0.0, 0.0))
    with pytest.raises(InputError, match="mm deep in"):
        _read(scene, path, pod_error=Displacement(0.001, 0.0, 0.0))
    corner = max(float(np.linalg.norm(body.T_parent_shape[:2, 3])) for body in cell.pod.bodies)
    assert _read(scene, path, pod_error=Displacement(0.0, 0.0, 0.0025 / corner))
    with pytest.raises(InputError, match="mm deep in"):
        _read(scene, path, pod_error=Displacement(0.0, 0.0, 0.0015 / corner))


def test_an_item_may_lie_anywhere_in_its_bin_and_nowhere_far_beside_it(cell: Cell, tmp_path: Path) -> None:
    """Its middle within 0.15 m of the bin's room, in each direction."""
    bin_, path = cell.pod.bins["bin_E"], tmp_path / "astray.json"
    item = cell.item("crayola_24_ct")
    low = np.array([0.0, bin_.room.y_range[0], bin_.room.floor_back])
    high = np.array([bin_.room.depth, bin_.room.y_range[1], bin_.room.ceiling_front])
    middle = (low + high) / 2
    for axis in range(3):
        for edge, outwards in ((low, -1.0), (high, 1.0)):
            for beyond, is_astray in ((0.149, False), (0.151, True)):
                p = middle.copy()
                p[axis] = edge[axis] + outwards * beyond
                placed = PlacedItem("one", item, "bin_E", cell.T_world_place(bin_) @ pose(p))
                scene = Scene(cell, cell.T_world_pod, (placed,), PoseNoise(0.1, 3.0), seed=0)
                write_scene(scene, path)
                try:
                    read_scene(path)
                except InputError as error:
                    assert ("one is 0.15 m away from bin_E" in str(error)) is is_astray
                else:
                    assert not is_astray


@pytest.mark.parametrize(
    ("down", "aside", "told"), [(0.012, 0.008, "12.0 mm deep in tote_floor"),
                                (0.008, 0.012, "12.0 mm deep in tote_wall_right")],
)  # fmt: skip
def test_the_deepest_of_several_solids_is_named(
    cell: Cell, tmp_path: Path, refused: Refused, down: float, aside: float, told: str
) -> None:
    """In a corner of the tote: through its floor by the one and through a wall by the other."""
    wall = next(body for body in cell.tote_bodies if body.name == "tote_wall_right")
    inside = float(wall.T_parent_shape[1, 3] + wall.shape.extents[1] / 2)
    placed = _in_tote(cell, -down)
    T = placed.T_world_item.copy()
    T[1, 3] = inside + float(placed.item.shape.extents[1]) / 2 - aside
    scene = replace(make_scene(cell), items=(replace(placed, T_world_item=T),))
    assert f"one stands {told}; correct its pose" in refused(lambda: _read(scene, tmp_path / "s.json"))


def test_overlaps_are_allowed_by_the_mean_noise_of_both(cell: Cell, tmp_path: Path) -> None:
    below = make_scene(cell).items[0]
    for sunk, is_refused in ((0.0014, False), (0.0016, True)):
        T = pose((0, 0, float(below.item.shape.extents[2]) - sunk)) @ below.T_world_item
        scene = replace(make_scene(cell), items=(below, replace(below, id="above", T_world_item=T)))
        if is_refused:
            with pytest.raises(InputError, match=r"overlap by 1\.6 mm"):
                _read(scene, tmp_path / "s.json")
        else:
            assert _read(scene, tmp_path / "s.json")


@pytest.mark.parametrize(
    ("moved", "is_refused"),
    [
        ((0.0, 0.0, 0.0), False),
        ((0.0, 0.0, -0.003), True),
        ((0.004, 0.0, 0.0), True),
        ((0.1, 0.0, 0.0), False),
    ],
)
def test_an_item_may_lie_in_the_hollow_of_another(
    cell: Cell, tmp_path: Path, moved: tuple[float, float, float], is_refused: bool
) -> None:
    """A ball in a bowl, 30 mm deep in its outer shape; deeper, or in its wall, it is not where it can be."""
    bowl, ball = cell.item("platinum_pets_dog_bowl"), cell.item("rawlings_baseball")
    T_bowl = cell.places["tote"].T_carrier_place @ pose((0.0, 0.0, float(bowl.shape.extents[2]) / 2))
    bottom = bowl.shape.extents[2] / 2 - bowl.hollows[0].depth
    T_ball = pose(np.array((0.0, 0.0, bottom + ball.shape.size[0])) + moved)
    items = PlacedItem("bowl", bowl, TOTE, T_bowl), PlacedItem("ball", ball, TOTE, T_bowl @ T_ball)
    scene = replace(make_scene(cell), items=items)
    if is_refused:
        with pytest.raises(InputError, match="bowl and ball overlap by"):
            _read(scene, tmp_path / "s.json")
    else:
        assert _read(scene, tmp_path / "s.json")


def test_an_item_in_a_corner_of_an_obstacle_is_told_as_such(cell: Cell, tmp_path: Path) -> None:
    """Far from the obstacle's middle, as most of what stands in the way is."""
    boom = next(body for body in cell.obstacles.bodies if body.name == "camera_boom")
    np.testing.assert_allclose(boom.T_parent_shape[:3, 3] + boom.shape.extents / 2, (-0.981, -0.904, 2.163))
    placed = PlacedItem("one", cell.item("crayola_24_ct"), TOTE, pose((-0.981, -0.919, 1.682)))
    with pytest.raises(InputError, match=r"one stands .* mm deep in camera_boom"):
        _read(replace(make_scene(cell), items=(placed,)), tmp_path / "s.json")


@pytest.mark.parametrize("noise", [0.0, 0.003])
def test_what_the_cup_holds_begins_within_the_bellows_and_what_is_uncertain(
    cell: Cell, tmp_path: Path, noise: float
) -> None:
    """A ball over the cup, no farther from it than that and no deeper in the tool."""
    item, tool = cell.item("rawlings_baseball"), cell.robot.tool
    radius, slack = item.shape.size[0], 0.005 + tool.cup.stroke + noise
    for begins, told in (
        (tool.cup.radius + slack - 1e-5, ""), (tool.cup.radius + slack + 1e-5, "from the tip of the cup"),
        (1e-5 - slack, ""), (-slack - 1e-5, "behind the tip of the cup"),
    ):  # fmt: skip
        held = HeldItem("ball", item, pose((0.0, 0.0, begins + radius)))
        scene = replace(make_scene(cell), held=held)
        if told:
            with pytest.raises(InputError, match=told):
                _read(scene, tmp_path / "s.json", noise)
        else:
            assert _read(scene, tmp_path / "s.json", noise).held is not None


@pytest.mark.parametrize("noise", [0.0, 0.003])
@pytest.mark.parametrize("pod_error", [0.0, 0.004])
def test_an_item_may_hang_10_mm_over_its_floor_and_by_what_poses_are_off(
    cell: Cell, tmp_path: Path, noise: float, pod_error: float
) -> None:
    scene = make_scene(cell)
    first = scene.items[0]
    on_floor = cell.pod.bins["bin_A"].room.floor_back + first.item.shape.extents[2] / 2
    T = cell.pod.bins["bin_A"].T_carrier_place @ pose((0.33, 0.0, on_floor))
    alone, most = replace(first, T_world_item=T), 0.010 + noise + pod_error
    error = Displacement(x=pod_error)
    path = tmp_path / "s.json"
    assert _read(_lowered(replace(scene, items=(alone,)), alone, dz=most - 1e-4), path, noise, error)
    with pytest.raises(
        InputError, match=rf"items\[0\].position: {first.id} floats: row_ABC_floor_flat, the "
    ):
        _read(_lowered(replace(scene, items=(alone,)), alone, dz=most + 1e-4), path, noise, error)


def test_the_gap_under_an_item_is_told_and_what_to_do(cell: Cell, written: Path, refused: Refused) -> None:
    scene = make_scene(cell)
    write_scene(_lowered(scene, scene.items[0], dz=0.05), written)
    message = refused(lambda: read_scene(written))
    assert "is 50.0 mm away; put it onto what carries it, or state in noise how far" in message


def test_what_lies_on_another_item_does_not_float(cell: Cell, tmp_path: Path) -> None:
    scene = make_scene(cell)
    below = scene.items[0]
    above = replace(below, id="above", T_world_item=pose((0, 0, 0.025)) @ below.T_world_item)
    both = replace(scene, items=(above, below))
    assert _read(both, tmp_path / "s.json").items
    with pytest.raises(InputError, match="above floats"):
        _read(both.without(below.id), tmp_path / "s.json")


@pytest.mark.parametrize(("beyond", "is_floating"), [(-1e-4, False), (1e-4, True)])
def test_an_item_may_be_over_another_by_what_the_poses_of_both_are_off(
    cell: Cell, tmp_path: Path, beyond: float, is_floating: bool
) -> None:
    """Of a long item and a short one, whose turns move their ends unlike."""
    below = make_scene(cell).items[0]
    ball, noise = cell.item("rawlings_baseball"), PoseNoise(0.001, 0.05)
    room = 0.01 + noise.bound(below.item) + noise.bound(ball)
    over = below.item.shape.extents[2] / 2 + ball.shape.size[0] + room + beyond
    above = PlacedItem("above", ball, below.location, pose((0, 0, over)) @ below.T_world_item)
    for items in ((below, above), (above, below)):
        source = Source(Path("scene.json"))
        check_floating(source, replace(make_scene(cell), items=items, noise=noise))
        assert ["above floats" in problem.text for problem in source.problems] == [True] * is_floating


def test_where_a_cloud_shows_what_else_stands_there_nothing_is_told_to_float(cell: Cell) -> None:
    scene = make_scene(cell)
    seen = Cloud(Path("cloud.npy"), np.eye(4), np.zeros((1, 3)), 0.002, 0.001)
    for cloud, told in ((None, 1), (seen, 0)):
        source = Source(Path("scene.json"))
        check_floating(source, replace(_lowered(scene, scene.items[0], dz=0.05), cloud=cloud))
        assert len(source.problems) == told


def test_what_the_cup_holds_may_be_listed_where_it_was_seen(cell: Cell, tmp_path: Path) -> None:
    scene = make_scene(cell)
    seen = replace(scene.items[0], T_world_item=pose((0, 0, 0.05)) @ scene.items[0].T_world_item)
    held = HeldItem(seen.id, seen.item, pose((0.0, 0.0, seen.item.shape.extents[2] / 2)))
    assert _read(replace(scene, items=(seen,), held=held), tmp_path / "s.json").held is not None


def test_an_item_of_the_tote_may_be_in_the_air_far_from_everything(cell: Cell, tmp_path: Path) -> None:
    """As it does while it falls into the tote."""
    placed = PlacedItem("one", cell.item("crayola_24_ct"), TOTE, pose((-0.7, -0.6, 1.2)))
    assert _read(replace(make_scene(cell), items=(placed,)), tmp_path / "s.json").items


@pytest.mark.parametrize("n", [3, 4, 12])
def test_many_mistakes_of_one_kind_are_one_line_with_their_cause(
    cell: Cell, written: Path, refused: Refused, n: int
) -> None:
    """A pod that stands elsewhere, or poses in another frame: not as many lines as there are items."""
    scene = make_scene(cell)
    for placed in scene.items[:n]:
        scene = scene.moved(replace(placed, T_world_item=pose((0, 3.0, 0)) @ placed.T_world_item))
    write_scene(scene, written)
    lines = refused(lambda: read_scene(written)).splitlines()
    if n <= 3:
        assert len(lines) == n and all("m away from bin_" in line for line in lines)
    else:
        (line,) = lines
        assert f"and {n - 1} more are like it; is T_world_pod where the pod stands?" in line
        assert "items[0]" in line


def _one_in_a_bin(cell: Cell, p: Array, noise: float) -> tuple[Scene, list[str]]:
    """A scene with one box in a bin whose frame is the world's but higher; and what is told of it."""
    bin_ = cell.pod.bins["bin_E"]
    placed = PlacedItem("one", cell.item("crayola_24_ct"), "bin_E", bin_.T_carrier_place @ pose(p))
    scene = Scene(cell, np.eye(4), (placed,), PoseNoise(noise, 0.0), seed=0)
    source = Source(Path("scene.json"))
    check_places(source, scene)
    check_floating(source, scene)
    return scene, [problem.text for problem in source.problems]


def test_what_is_exactly_as_far_astray_as_may_be_is_not_astray(cell: Cell) -> None:
    room = cell.pod.bins["bin_E"].room
    for beyond, is_astray in ((0.15, False), (float(np.nextafter(0.15, 1.0)), True)):
        told = _one_in_a_bin(cell, np.array([-beyond, *((room.low + room.high) / 2)[1:]]), noise=1.0)[1]
        assert ["away from bin_E" in text for text in told] == [True] * is_astray


def test_what_is_exactly_as_deep_in_the_floor_as_its_pose_may_be_off_is_not_sunk(cell: Cell) -> None:
    bin_ = cell.pod.bins["bin_E"]
    half = float(cell.item("crayola_24_ct").shape.extents[2]) / 2
    p = np.array([0.3, 0.0, bin_.room.floor_back + half - 0.008])
    scene, _ = _one_in_a_bin(cell, p, 0.0)
    z = float((inverse(bin_.T_carrier_place) @ scene.items[0].T_world_item)[2, 3])
    under = bin_.room.floor_back - (z - half)
    for noise, is_sunk in ((under - 0.005, False), (under - 0.005 - 1e-15, True)):
        told = _one_in_a_bin(cell, p, noise)[1]
        assert ["under the floor of bin_E" in text for text in told] == [True] * is_sunk


def test_what_is_exactly_as_far_over_the_floor_as_its_pose_may_be_off_does_not_float(cell: Cell) -> None:
    bin_ = cell.pod.bins["bin_E"]
    half = float(cell.item("crayola_24_ct").shape.extents[2]) / 2
    p = np.array([0.33, 0.0, bin_.room.floor_back + half + 0.015])
    scene, _ = _one_in_a_bin(cell, p, 0.0)
    solids = PosedSolids.of(scene, scene.items, scene.standing)
    others = np.arange(1, len(solids.names))
    width = float(gaps(solids, np.zeros_like(others), others).width.min())
    assert width == pytest.approx(0.015)
    for noise, is_floating in ((width - 0.01, False), (width - 0.01 - 1e-15, True)):
        told = _one_in_a_bin(cell, p, noise)[1]
        assert ["one floats" in text for text in told] == [True] * is_floating
