"""What counts as deliverable."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from bench import deliverable
from pickcli.cell.cell_file import load_cell
from pickcli.geometry import pose
from pickcli.scene.scene import PlacedItem, PoseNoise, Scene
from pickcli.trial.pose_noise import DEFAULT_NOISE

CELL = load_cell("apc2016_delft")


def test_what_carries_the_target_or_what_cannot_be_taken_stays() -> None:
    """In one stack the target lies on a box; in another a box lies under a dumbbell; a bar lies free."""
    on_box = ("kleenex_tissue_box", "crayola_24_ct")
    heavy = ("staples_index_cards", "fitness_gear_3lb_dumbbell")
    scene = _stacks(on_box, heavy, ("dove_beauty_bar",))
    left = deliverable._cleared_as_it_can_be(scene, scene.find("crayola_24_ct"), [CELL.robot.tool])
    assert {p.id for p in scene.items} - {p.id for p in left.items} == {"dove_beauty_bar"}
    all_gone = deliverable.cleared(scene, scene.find("crayola_24_ct"), [CELL.robot.tool])
    assert {p.id for p in all_gone.items} == {"crayola_24_ct", "fitness_gear_3lb_dumbbell"}


def test_an_order_of_plans_ends_where_nothing_more_can_be_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    """A chain, each of which is plannable once the one before is gone; then with a link that never is."""
    chain = ("dove_beauty_bar", "crayola_24_ct", "kleenex_tissue_box", "staples_index_cards")
    scene = _stacks(*((name,) for name in chain))
    target, asked = scene.find("staples_index_cards"), []

    def plannable(never: str = "") -> None:
        def ask(item: PlacedItem, left: Scene, _: object) -> bool:
            asked.append(item.id)
            before = chain[: chain.index(item.id)]
            return item.id != never and not {p.id for p in left.items} & set(before)

        monkeypatch.setattr(deliverable, "is_plannable", ask)

    warm = [SimpleNamespace(cell=CELL)]
    plannable()
    assert deliverable._leads_to(target, scene, warm)  # type: ignore[arg-type]
    assert asked[-1] == target.id
    plannable(never="crayola_24_ct")
    assert not deliverable._leads_to(target, scene, warm)  # type: ignore[arg-type]


def test_what_is_known_of_poses_is_stated_and_moves_nothing() -> None:
    scene = _stacks(("dove_beauty_bar",))
    known = deliverable.as_known(scene)
    assert known.noise == DEFAULT_NOISE and known.pod_error.x > 0.0
    assert known.items == scene.items and known.T_world_pod is scene.T_world_pod


def _stacks(*stacks: tuple[str, ...]) -> Scene:
    """Items of bin_E in stacks side by side, each flat on the one before."""
    cell_bin, items = CELL.pod.bins["bin_E"], []
    for k, names in enumerate(stacks):
        top = cell_bin.room.floor_back
        for name in names:
            item = CELL.item(name, 2016)
            height = float(item.shape.extents[2])
            at = pose((0.3, 0.1 * (k - 1), top + height / 2))
            top += height
            items.append(PlacedItem(name, item, "bin_E", CELL.T_world_place(cell_bin) @ at))
    return Scene(CELL, CELL.T_world_pod, tuple(items), PoseNoise())


@pytest.mark.parametrize(("name", "holds"), [
    ("crayola_24_ct", True), ("oral_b_toothbrush_green", True), ("fiskars_scissors_red", True),
    ("fitness_gear_3lb_dumbbell", False),
])  # fmt: skip
def test_is_holdable_says_what_a_cup_can_carry(name: str, holds: bool) -> None:
    assert deliverable.is_holdable(CELL.item(name, 2016), [CELL.robot.tool]) == holds


@pytest.mark.parametrize(("name", "holds"), [
    ("dove_beauty_bar", True), ("kleenex_tissue_box", False), ("fitness_gear_3lb_dumbbell", False),
])  # fmt: skip
def test_is_holdable_says_what_fingers_can_carry(name: str, holds: bool) -> None:
    """Baxter's open 56 mm; the dumbbell's mantle is wider, as is a box of tissues."""
    gripper = load_cell("apc2016_kth", arm="left").robot.tool
    assert gripper.gripper is not None
    assert deliverable.is_holdable(CELL.item(name, 2016), [gripper]) == holds


def test_what_one_of_several_tools_holds_is_holdable() -> None:
    cup, gripper = (load_cell("apc2016_kth", arm=arm).robot.tool for arm in ("right", "left"))
    tissues = CELL.item("kleenex_tissue_box", 2016)
    assert deliverable.is_holdable(tissues, [gripper, cup]) and not deliverable.is_holdable(
        tissues, [gripper]
    )
