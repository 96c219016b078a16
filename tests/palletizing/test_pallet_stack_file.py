"""Files of stacks: read as they were written, refused with mistakes, shown and listed."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pickcli.errors import InputError
from pickcli.files.packed_array import unpacked
from pickcli.page.page_scene import Fact, Tone
from pickcli.page.pallet_page import pallet_page
from pickcli.palletizing.drop_test import DropTest
from pickcli.palletizing.pallet_order import CONTAINERS, Carton, Pallet, PalletOrder
from pickcli.palletizing.pallet_stack import PalletStack, loads_on
from pickcli.palletizing.pallet_stack_file import (
    StackedPallet,
    read_pallet_stack,
    stack_text,
    stack_to_dict,
    write_pallet_stack,
)
from pickcli.palletizing.random_pallet_order import random_pallet_order
from pickcli.palletizing.stacking import stack_all, stack_as_they_come
from support.command_line import apc, refused

TESTED = DropTest(0.0004, 0.0012, ())


@pytest.fixture(scope="module")
def stack() -> PalletStack:
    return stack_all(random_pallet_order(14, seed=5))


@pytest.fixture
def path(stack: PalletStack, tmp_path: Path) -> Path:
    path = tmp_path / "stack.json"
    write_pallet_stack(path, stack, TESTED)
    return path


def test_a_stack_is_read_as_it_was_written(stack: PalletStack, path: Path) -> None:
    found = read_pallet_stack(path)
    assert [each.carton.id for each in found.placements] == [each.carton.id for each in stack.placements]
    for read, written in zip(found.placements, stack.placements, strict=True):
        np.testing.assert_allclose(read.low, written.low, atol=2e-6)
        np.testing.assert_allclose(read.bears_within, written.bears_within, atol=1e-6)
        assert (read.is_turned, read.rests_on) == (written.is_turned, written.rests_on)
        assert read.from_above == pytest.approx(written.from_above, abs=2e-6)
        assert read.carton == written.carton
    assert dict(found.loads) == pytest.approx(
        {p.carton.id: loads_on(stack)[p.carton.id] for p in stack.placements}, abs=1e-3
    )
    assert (found.pallet, found.clearance) == (stack.order.pallet, stack.order.clearance)
    assert (found.sinking, found.shift, found.left) == (0.0004, 0.0012, {})
    assert stack_text(found) == path.read_text()


def test_what_was_left_comes_with_its_reasons(tmp_path: Path) -> None:
    pallet = Pallet((0.5, 0.5), height=0.5)
    order = PalletOrder(pallet, tuple(Carton(f"c{k}", (0.5, 0.5, 0.3), 1.0) for k in range(2)))
    path = tmp_path / "stack.json"
    write_pallet_stack(path, stack_as_they_come(order), TESTED)
    found = read_pallet_stack(path)
    assert list(found.left) == ["c1"] and found.left["c1"]
    assert any("c1" in row for table in pallet_page(found).tables for row in table.rows)


def _twice(values: dict[str, Any]) -> None:
    values["placements"].append(values["placements"][0])


def _early(values: dict[str, Any]) -> None:
    values["placements"][0]["rests_on"] = [values["placements"][-1]["id"]]


def _askew(values: dict[str, Any]) -> None:
    values["placements"][0]["yaw_deg"] = 45


def _none(values: dict[str, Any]) -> None:
    values["placements"], values["left"] = [], []


def _left_as_well(values: dict[str, Any]) -> None:
    values["left"] = [{"id": values["placements"][0]["id"], "reasons": []}]


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (_twice, "is put up twice"), (_early, "which is not there yet"), (_askew, "yaw_deg"),
        (_none, "no carton is put up"), (_left_as_well, "is put up, too"),
    ],
)  # fmt: skip
def test_mistakes_are_told(change: Any, told: str, stack: PalletStack, tmp_path: Path) -> None:
    values = stack_to_dict(StackedPallet.of(stack, TESTED))
    values = json.loads(json.dumps(values))
    change(values)
    path = tmp_path / "stack.json"
    path.write_text(json.dumps(values))
    with pytest.raises(InputError, match=told):
        read_pallet_stack(path)


def test_on_its_page_every_carton_comes_down_to_its_place_after_those_before_it(path: Path) -> None:
    stack = read_pallet_stack(path)
    page = pallet_page(stack)
    assert page.motion is not None
    ended = 0.0
    for placement, track in zip(stack.placements, page.motion.tracks, strict=True):
        times, poses = unpacked(track.times), unpacked(track.poses)
        assert track.item == placement.carton.id and times[0] >= ended - 1e-4
        np.testing.assert_allclose(poses[-1, :3], placement.centre, atol=2e-4)
        np.testing.assert_allclose(poses[-2, :2], poses[-1, :2], atol=2e-4)  # straight down
        ended = times[-1]
    assert page.motion.duration == pytest.approx(ended, abs=1e-3)


def test_the_page_tells_what_the_verifier_has_against_a_stack(path: Path) -> None:
    stack = read_pallet_stack(path)
    last = stack.placements[-1]
    raised = replace(last, low=last.low + np.array([0.0, 0.0, 0.3]))
    floats = pallet_page(replace(stack, placements=(*stack.placements[:-1], raised)))
    assert Fact("verifier", "accepts it", Tone.GOOD) in pallet_page(stack).facts
    assert any(fact.tone is Tone.BAD and "rejects it" in fact.value for fact in floats.facts)
    (why,) = [table for table in floats.tables if table.title == "Rejected"]
    assert any("hangs in the air" in row[0] for row in why.rows)


def test_walls_of_a_container_are_drawn_outside_of_its_deck(tmp_path: Path) -> None:
    order = random_pallet_order(3, 6, CONTAINERS["roll_container"])
    write_pallet_stack(tmp_path / "s.json", stack_as_they_come(order), TESTED)
    deck, walls = pallet_page(read_pallet_stack(tmp_path / "s.json")).groups
    assert deck.bodies[0].shape.size[:2] == (0.8, 0.7)
    assert [body.name for body in walls.bodies] == ["wall -x", "wall +x", "wall +y"]
    inner = [
        abs(body.pose[k]) - body.shape.size[k] / 2 for body, k in zip(walls.bodies, (0, 0, 1), strict=True)
    ]
    assert inner == pytest.approx([0.4, 0.4, 0.35])


def test_a_stack_is_shown_listed_and_called_by_its_name(
    stack: PalletStack, path: Path, tmp_path: Path
) -> None:
    page, again = tmp_path / "a.html", tmp_path / "b.html"
    assert apc("show", path, "-o", page).code == 0 and apc("show", path, "-o", again).code == 0
    assert page.read_bytes() == again.read_bytes()
    told = json.loads(apc("inspect", path, "--json").out)
    assert told["n_placed"] == len(stack.placements) and told["n_left"] == 0
    order = tmp_path / "order.json"
    assert apc("make-pallet-order", "--cartons", 3, "-o", order).code == 0
    assert json.loads(apc("inspect", order, "--json").out)["n_cartons"] == 3
    refused(
        apc("plan-pallet", path, "-o", tmp_path / "x.json"),
        3,
        "is a stacked pallet, but an order of a pallet",
    )
