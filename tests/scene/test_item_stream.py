"""Streams: where items are at which time, files that give them back, and what is refused."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.errors import InputError, StaleError, UnknownNameError
from pickcli.random_scenes.make_stream import LANES, StreamRequest, make_stream
from pickcli.scene.item_stream import ItemStream, after_travel
from pickcli.scene.scene_file import scene_hash
from pickcli.scene.stream_file import read_stream, write_stream

CELL = "conveyor_sia20"


@pytest.fixture(scope="module")
def cell() -> Cell:
    return load_cell(CELL)


def drawn(cell: Cell, n: int = 12, speed: float = 0.33, seed: int = 4) -> ItemStream:
    return make_stream(cell, StreamRequest(n, speed, (0.03, 0.60)), seed)


def extent(stream: ItemStream, k: int, t: float) -> tuple[float, float]:
    """Rear and front of an item, m from the infeed."""
    riding = stream.items[k]
    reach = float(riding.item.shape.reach(riding.T_belt_item[:3, :3])[0])
    at = stream.travel_at(riding, t)
    return at - reach, at + reach


@settings(max_examples=20)
@given(st.floats(0.05, 0.5), st.integers(0, 1000))
def test_items_keep_the_gaps_and_the_first_enters_at_zero(speed: float, seed: int) -> None:
    stream = drawn(load_cell(CELL), 6, speed, seed)
    assert extent(stream, 0, 0.0)[0] == pytest.approx(0.0)
    for k in range(5):
        gap = extent(stream, k, 3.0)[0] - extent(stream, k + 1, 3.0)[1]
        assert 0.03 - 1e-9 <= gap <= 0.60 + 1e-9
    for riding in stream.items:
        reach = riding.item.shape.reach(riding.T_belt_item[:3, :3])
        y = abs(float(riding.T_belt_item[1, 3]))
        assert y <= LANES and y + reach[1] <= stream.belt.width / 2
        assert riding.T_belt_item[2, 3] == pytest.approx(reach[2])


def test_on_a_belt_that_stands_all_lie_within_the_window(cell: Cell) -> None:
    stream = make_stream(cell, StreamRequest(5, 0.0, (0.03, 0.1)), 2)
    first, last = stream.belt.window
    for t in (0.0, 7.0):
        x = [stream.travel_at(riding, t) for riding in stream.items]
        assert len(stream.scene_at(t).items) == 5 and first <= min(x) and max(x) <= last
    assert scene_hash(stream.scene_at(0.0)) == scene_hash(stream.scene_at(7.0))
    with pytest.raises(InputError, match="of 40 items fit within the window"):
        make_stream(cell, StreamRequest(40, 0.0, (0.1, 0.1)), 2)


def test_a_scene_has_what_is_on_the_belt_and_what_comes_next(cell: Cell) -> None:
    stream = drawn(cell, 40)
    for t in (-1.0, 0.0, 2.0, 9.0, 30.0):
        known = {
            riding.id
            for k, riding in enumerate(stream.items)
            if extent(stream, k, t)[1] >= -2.0 * stream.belt.length
            and extent(stream, k, t)[0] <= stream.belt.length
        }
        assert {placed.id for placed in stream.scene_at(t).items} == known and len(known) < 40
    assert not stream.scene_at(-100.0).items and not stream.scene_at(200.0).items


def test_the_first_item_is_on_the_belt_as_it_has_passed_the_infeed(cell: Cell) -> None:
    for seed in range(30):
        stream = drawn(cell, 2, seed=seed)
        assert stream.is_on_belt(stream.items[0], 0.0) and not stream.is_on_belt(stream.items[1], 0.0)


def test_the_belt_carries_a_scene_to_that_of_a_later_time(cell: Cell) -> None:
    stream = drawn(cell)
    before, after = stream.scene_at(6.0), stream.scene_at(7.0)
    carried = after_travel(before, "belt", stream.speed * 1.0)
    both = {placed.id for placed in before.items} & {placed.id for placed in after.items}
    assert both
    for item_id in both:
        assert np.allclose(carried.find(item_id).T_world_item, after.find(item_id).T_world_item)


def test_what_is_known_of_a_pose_gets_less_with_time(cell: Cell) -> None:
    from dataclasses import replace

    stream = replace(drawn(cell), speed_error=0.01)
    riding = stream.items[0]
    placed = stream.scene_at(riding.stamp + 4.0).find(riding.id)
    assert placed.noise is not None and placed.noise.position == pytest.approx(0.04)
    later = after_travel(stream.scene_at(riding.stamp + 4.0), "belt", 0.33, 0.01).find(riding.id)
    assert later.noise is not None and later.noise.position == pytest.approx(0.05)


def test_a_file_gives_back_what_was_written(cell: Cell, tmp_path: Path) -> None:
    stream = drawn(cell)
    write_stream(stream, tmp_path / "a.json")
    again = read_stream(tmp_path / "a.json")
    write_stream(again, tmp_path / "b.json")
    assert scene_hash(again.scene_at(5.0)) == scene_hash(stream.scene_at(5.0))
    assert (again.speed, again.conveyor, again.seed) == (stream.speed, stream.conveyor, stream.seed)
    assert [r.stamp for r in again.items] == [r.stamp for r in stream.items]


def test_the_same_seed_gives_the_same_bytes(cell: Cell, tmp_path: Path) -> None:
    for name in "ab":
        write_stream(drawn(cell), tmp_path / f"{name}.json")
    assert (tmp_path / "a.json").read_bytes() == (tmp_path / "b.json").read_bytes()
    write_stream(drawn(cell, seed=5), tmp_path / "c.json")
    assert (tmp_path / "a.json").read_bytes() != (tmp_path / "c.json").read_bytes()


def test_items_one_by_one_may_lie_where_others_lay_and_only_one_is_there(cell: Cell, tmp_path: Path) -> None:
    stream = make_stream(cell, StreamRequest(30, 0.0, (0.1, 0.2), one_by_one=True), 2)
    write_stream(stream, tmp_path / "a.json")
    again = read_stream(tmp_path / "a.json")
    assert again.one_by_one and len(again.items) == 30
    assert [placed.id for placed in again.scene_at(0.0).items] == [again.items[0].id]
    last = again.items[-1].id
    assert [placed.id for placed in again.presenting(last).scene_at(0.0).items] == [last]
    assert drawn(cell).presenting(drawn(cell).items[0].id).items[1:] != ()


def put(*path: Any, value: Any) -> Callable[[Any], None]:
    def change(data: Any) -> None:
        for part in path[:-1]:
            data = data[part]
        data[path[-1]] = value

    return change


def moved(i: int, *by: float) -> Callable[[Any], None]:
    def change(data: Any) -> None:
        at = data["items"][i]["position"]
        data["items"][i]["position"] = [p + d for p, d in zip(at, by, strict=True)]

    return change


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (put("speed", value=-0.1), "speed: "),
        (put("speed", value=float("nan")), "NaN is not JSON"),
        (put("speed", value=0.6), "beyond the 0.5 m/s of belt"),
        (put("speed_error", value=1.2), "speed_error: "),
        (put("speed_error", value=0.4), "speed_error: 0.4 m/s: a belt that runs at"),
        (put("items", 0, "noise", value={"position": -1}), "noise"),
        (put("one_by_one", value=True), "one by one on a belt that stands"),
        (put("conveyor", value="bellt"), "did you mean 'belt'?"),
        (put("conveyor", value="tote"), "unknown conveyor 'tote'"),
        (put("items", 1, "id", value="A"), "stands twice"),
        (put("items", 1, "id", value="lance"), "'lance' is the name of a link of the robot"),
        (put("items", 1, "id", value="tote_floor"), "'tote_floor' is the name of a part of the cell"),
        (put("items", 1, "id", value="belt"), "'belt' is the name of a part of the cell"),
        (put("items", 1, "name", value="no_such"), "unknown item 'no_such'"),
        (put("items", 2, "stamp", value=0.0), "before"),
        (put("items", 2, "quaternion", value=[1, 1, 0, 0]), "expected a length of 1"),
        (moved(0, 0.0, 0.3, 0.0), "beyond the edge of the belt"),
        (moved(0, 0.0, 0.0, -0.02), "20.0 mm deep in the belt"),
        (moved(0, 0.0, 0.0, 0.03), "30.0 mm over the belt"),
        (moved(0, 90.0, 0.0, 0.0), "m from the infeed of a belt of 3.1 m"),
    ],
)
def test_a_file_that_cannot_be_is_refused_with_its_line(
    cell: Cell, tmp_path: Path, change: Callable[[Any], None], told: str
) -> None:
    path = tmp_path / "stream.json"
    write_stream(drawn(cell, 4), path)
    data = json.loads(path.read_text())
    data["items"][0]["id"] = "A"
    change(data)
    path.write_text(json.dumps(data, indent=1))
    with pytest.raises(InputError) as error:
        read_stream(path)
    assert told in str(error.value) and str(path) in str(error.value)


def test_stamps_of_a_clock_that_began_long_ago_are_told_what_to_subtract(cell: Cell, tmp_path: Path) -> None:
    path = tmp_path / "stream.json"
    write_stream(drawn(cell, 4), path)
    data = json.loads(path.read_text())
    for item in data["items"]:
        item["stamp"] += 1_764_500_000.0
    path.write_text(json.dumps(data))
    with pytest.raises(InputError, match="subtract the first stamp from all, and from --now") as error:
        read_stream(path)
    assert str(error.value).count("stamp:") == 1 and "ms" not in str(error.value).split("stamp:")[1]


def test_a_stream_written_by_hand_needs_no_seed(cell: Cell, tmp_path: Path) -> None:
    path = tmp_path / "stream.json"
    write_stream(drawn(cell, 2), path)
    data = json.loads(path.read_text())
    del data["seed"]
    path.write_text(json.dumps(data))
    assert read_stream(path).seed == 0


def test_items_that_overlap_at_any_time_are_refused(cell: Cell, tmp_path: Path) -> None:
    path = tmp_path / "stream.json"
    write_stream(drawn(cell, 3), path)
    data = json.loads(path.read_text())
    # The second enters while the first, of the same size, has only gone 1 cm.
    data["items"][1] = {**data["items"][0], "id": "second", "stamp": 0.01 / 0.33}
    path.write_text(json.dumps(data))
    with pytest.raises(InputError, match="and second overlap by"):
        read_stream(path)


def test_a_stream_of_another_cell_is_stale(cell: Cell, tmp_path: Path) -> None:
    path = tmp_path / "stream.json"
    write_stream(drawn(cell, 3), path)
    with pytest.raises(StaleError, match="made for cell conveyor_sia20"):
        read_stream(path, load_cell("apc2016_delft"))


def test_a_cell_without_a_conveyor_says_which_has_one(cell: Cell) -> None:
    with pytest.raises(InputError, match="--cell conveyor_sia20"):
        make_stream(load_cell("apc2016_delft"), StreamRequest(1, 0.1, (0.1, 0.2)), 0)
    with pytest.raises(InputError, match=r"streams last 1e\+06 s at most"):
        make_stream(cell, StreamRequest(5, 1e-7, (0.3, 0.4)), 0)
    with pytest.raises(UnknownNameError, match="belt"):
        make_stream(cell, StreamRequest(1, 0.1, (0.1, 0.2)), 0, "belt_2")
    with pytest.raises(InputError, match=r"runs at 0.5 m/s at most"):
        make_stream(cell, StreamRequest(1, 0.6, (0.1, 0.2)), 0)
