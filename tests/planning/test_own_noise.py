"""Bounds of the error of single items' poses: the same as the scene's where all are equal, else its own."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.collision.motion_segment import Mode
from pickcli.errors import InputError
from pickcli.motion.segment import SegmentKind
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.scene.scene import PoseNoise, Scene
from pickcli.scene.scene_file import read_scene, scene_hash, write_scene
from pickcli.scene.touching import PosedSolids
from pickcli.verification.moving_parts import fixtures
from pickcli.verification.verify import verify
from support.scene_files import make_scene

CELL = load_cell("apc2016_delft")
SceneWith = Callable[..., Scene]

NOISE = PoseNoise(0.002, float(np.radians(1.0)))


def with_own(scene: Scene, noise: PoseNoise) -> Scene:
    """The scene with a default of no error, and these bounds for every item."""
    items = tuple(replace(placed, noise=noise) for placed in scene.items)
    return replace(scene, noise=PoseNoise(), items=items)


def test_equal_bounds_of_all_items_are_those_of_the_scene(
    context: PlanningContext, cell: Cell, home: Start
) -> None:
    """The same plan, byte by byte, and the same verdict."""
    scene = replace(make_scene(cell), noise=NOISE)
    own, placed = with_own(scene, NOISE), scene.items[0]
    query = PickQuery(placed.location, placed.id)
    one, other = plan_pick(context, scene, query, home), plan_pick(context, own, query, home)
    assert one.trajectory.positions.tobytes() == other.trajectory.positions.tobytes()
    assert one.segments == other.segments
    assert verify(one, scene).reasons == verify(other, own).reasons == ()
    certificates = [verify(plan, s).certificate for plan, s in ((one, scene), (other, own))]
    assert len({each.min_clearance for each in certificates if each is not None}) == 1
    assert None not in certificates


@given(position=st.floats(0.0, 0.02), angle=st.floats(0.0, 0.1), k=st.integers(0, 10))
def test_only_the_item_itself_is_less_certain(position: float, angle: float, k: int) -> None:
    scene = replace(make_scene(CELL), noise=NOISE)
    placed = scene.items[k % len(scene.items)]
    own = scene.moved(replace(placed, noise=PoseNoise(position, angle)))
    expected = {p.id: scene.bound(p) for p in scene.items}
    expected[placed.id] = position + angle * placed.item.shape.bounding_radius
    assert {f.name: f.slack for f in fixtures(own) if f.name in expected} == pytest.approx(expected)
    solids = PosedSolids.of(own, own.items, ())
    assert dict(zip(solids.names, solids.bound.tolist(), strict=True)) == pytest.approx(expected)


def test_a_less_certain_item_is_kept_clear_of_by_as_much(
    context: PlanningContext, scene_with: SceneWith, home: Start
) -> None:
    """A cup 20 mm over a box counts as nearer by what the box may be off, and by no more."""
    scene = replace(scene_with(("crayola_24_ct", "bin_B", 0.25, 0.0)), noise=PoseNoise())
    plan = plan_pick(context, scene, PickQuery("bin_B", "crayola_24_ct"), home)
    contact = next(s for s in plan.segments if s.kind is SegmentKind.CONTACT)
    q = plan.trajectory.sample(contact.t_start)[0]
    (box,) = scene.items
    mode = Mode(contact.tool_state)
    before = context.checker_for(scene, mode).clearance(q)
    assert before.item == box.id
    vague = scene.moved(replace(box, noise=PoseNoise(0.002, 0.0)))
    after = context.checker_for(vague, mode).clearance(q)
    assert after.distance == pytest.approx(before.distance - 0.002, abs=1e-5)


def test_a_plan_for_poses_better_known_is_refused(context: PlanningContext, cell: Cell, home: Start) -> None:
    scene = replace(make_scene(cell), noise=PoseNoise())
    placed = scene.items[0]
    plan = plan_pick(context, scene, PickQuery(placed.location, placed.id), home)
    assert verify(plan, scene).reasons == ()
    vague = replace(scene, items=tuple(replace(p, noise=PoseNoise(0.02, 0.1)) for p in scene.items))
    whats = {reason.what for reason in verify(replace(plan, scene_hash=scene_hash(vague)), vague).reasons}
    assert whats & {"collision", "planned contact too deep"}


def test_own_bounds_come_back_and_count(cell: Cell, tmp_path: Path) -> None:
    scene = make_scene(cell)
    own = scene.moved(replace(scene.items[0], noise=PoseNoise(0.001, 0.01)))
    assert scene_hash(own) != scene_hash(scene)
    write_scene(own, tmp_path / "scene.json")
    back = read_scene(tmp_path / "scene.json")
    assert scene_hash(back) == scene_hash(own)
    assert back.items[0].noise == PoseNoise(0.001, 0.01) and back.items[1].noise is None


@pytest.mark.parametrize("bad", [{"position": -0.001, "angle": 0.0}, {"position": 0.001}, 0.002])
def test_bad_own_bounds_are_refused_where_they_are(cell: Cell, tmp_path: Path, bad: object) -> None:
    path = tmp_path / "scene.json"
    write_scene(make_scene(cell), path)
    content = json.loads(path.read_text())
    content["items"][1]["noise"] = bad
    path.write_text(json.dumps(content))
    with pytest.raises(InputError, match=r"items\.1\.noise|items\[1\]\.noise"):
        read_scene(path)


def test_large_own_bounds_are_warned_of(cell: Cell, tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    scene = make_scene(cell)
    first = scene.items[0]
    path = tmp_path / "scene.json"
    write_scene(scene.moved(replace(first, noise=PoseNoise(0.03, 0.0))), path)
    read_scene(path)
    assert f"{first.id} counts as 30 mm larger" in caplog.text
    content = json.loads(path.read_text())
    content["accepted_warnings"] = [f"large_noise:{first.id}.position"]
    path.write_text(json.dumps(content))
    caplog.clear()
    read_scene(path)
    assert "larger all around" not in caplog.text
