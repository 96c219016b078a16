"""The verifier of stacks accepts what stackings make, and refuses whatever is changed in it."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import pose
from pickcli.palletizing.drop_test import DropTest, drop_test
from pickcli.palletizing.pallet_order import CONTAINERS, Carton, Pallet, PalletOrder
from pickcli.palletizing.pallet_order_file import write_pallet_order
from pickcli.palletizing.pallet_stack import Placement
from pickcli.palletizing.pallet_stack_file import StackedPallet, read_pallet_stack, write_pallet_stack
from pickcli.palletizing.random_pallet_order import random_pallet_order
from pickcli.palletizing.stack_verification import verify_stack
from pickcli.palletizing.stacking import stack_all, stack_as_they_come
from pickcli.palletizing.support_polygon import rectangle
from pickcli.verification.fcl_solids import Solid
from support.command_line import apc, misused, refused

UNTESTED = DropTest(0.0, 0.0, ())
BLOCK, PLANK = Carton("block", (0.5, 0.4, 0.2), 5.0, 3.0), Carton("plank", (0.8, 0.4, 0.05), 2.0, 1.0)
POST, LID = Carton("post", (0.295, 0.4, 0.2), 5.0, 3.0), Carton("lid", (0.5, 0.4, 0.1), 1.0, 1.0)
BRIDGE = PalletOrder(Pallet((0.8, 0.4), 0.1, 1.0, 50.0), (BLOCK, POST, PLANK, LID))

Values = dict[str, Any]


def stacked(path: Path, order: PalletOrder, seed: int | None = None) -> StackedPallet:
    stack = stack_as_they_come(order) if seed is None else stack_all(order, seed)
    write_pallet_stack(path, stack, UNTESTED)
    return read_pallet_stack(path)


@pytest.fixture(scope="module")
def bridge(tmp_path_factory: pytest.TempPathFactory) -> Values:
    """A plank on two blocks side by side, and a lid on it."""
    path = tmp_path_factory.mktemp("stack") / "bridge.json"
    assert verify_stack(stacked(path, BRIDGE)).reasons == ()
    values: Values = json.loads(path.read_text())
    assert values["placements"][2]["rests_on"] == ["block", "post"]
    assert values["placements"][3]["rests_on"] == ["plank"]
    return values


@pytest.mark.parametrize("container", sorted(CONTAINERS))
@pytest.mark.parametrize("seed", range(4))
def test_stacks_are_accepted_and_no_solids_meet(container: str, seed: int, tmp_path: Path) -> None:
    order = random_pallet_order(16, 900 + seed, CONTAINERS[container])
    stack = stacked(tmp_path / "s.json", order, seed if seed % 2 else None)
    verdict = verify_stack(stack, order)
    assert verdict.reasons == () and len(stack.placements) > 8
    assert verdict.clearance >= order.clearance - 5e-6 and verdict.margin >= -5e-6
    assert 0.0 < verdict.load_share <= 1.0
    solids = [Solid(Shape(ShapeKind.BOX, tuple((p.size - 1e-5).tolist()))) for p in stack.placements]
    for solid, placement in zip(solids, stack.placements, strict=True):
        solid.place(pose(placement.centre))
    assert not any(a.meets(b) for k, a in enumerate(solids) for b in solids[:k])


def _moved(values: Values, k: int, by: tuple[float, float, float]) -> None:
    placement = values["placements"][k]
    placement["position"] = [a + b for a, b in zip(placement["position"], by, strict=True)]
    placement["comes_down_from"] += by[2]


def _of(k: int, **changes: Any) -> Callable[[Values], None]:
    return lambda values: values["placements"][k].update(changes)


def _by(k: int, *by: float) -> Callable[[Values], None]:
    x, y, z = by
    return lambda values: _moved(values, k, (x, y, z))


def _larger(values: Values) -> None:
    """The plank's polygon, stretched a millimetre beyond what bears it."""
    corners = np.array(values["placements"][2]["borne_within"])
    middle = corners.mean(axis=0)
    values["placements"][2]["borne_within"] = (middle + (corners - middle) * 1.0025).tolist()


def _bare(values: Values) -> None:
    del values["placements"][1]
    values["placements"][1]["rests_on"] = ["block"]


def _low(values: Values) -> None:
    values["pallet"]["height"] = 0.4


def _weak(values: Values) -> None:
    values["pallet"]["bears"] = 12.0


def _walled(values: Values) -> None:
    values["pallet"]["walls"] = ["-x"]


@pytest.mark.parametrize(
    ("change", "told", "where"),
    [
        (_by(0, -0.001, 0.0, 0.0), "over the edge of the pallet", "block"),
        (_walled, "over the edge of the pallet", "block"),
        (_low, "too high", "lid"),
        (_by(1, -0.006, 0.0, 0.0), "overlaps", "post"),
        (_by(1, -0.001, 0.0, 0.0), "meets another on its way down", "post"),
        (_of(2, comes_down_from=0.22), "its way down begins too low", "plank"),
        (_by(2, 0.0, 0.0, 0.001), "hangs in the air", "plank"),
        (_by(2, 0.0, 0.0, -0.001), "is sunk in what bears it", "plank"),
        (_of(2, rests_on=["block"]), "rests on what is not stated", "plank"),
        (_of(1, rests_on=["block"]), "does not rest on what is stated", "post"),
        (_by(2, -0.9, 0.0, 0.0), "is not borne within its polygon", "plank"),
        (_larger, "is not borne within its polygon", "plank"),
        (_bare, "is not borne within its polygon", "plank"),
        (_of(3, borne_within=[[-0.4, -0.2], [-0.39, -0.2], [-0.4, -0.19]]), "would tip", "lid"),
        (_of(3, borne_within=[]), "would tip", "lid"),
        (_of(0, bears=2.9), "overloaded", "block"),
        (_of(2, load=0.9), "another load is stated", "plank"),
        (_of(3, mass=1.1), "overloaded", "plank"),
        (_weak, "overloaded", "the pallet"),
    ],
)
def test_what_is_changed_is_refused(
    change: Callable[[Values], None], told: str, where: str, bridge: Values, tmp_path: Path
) -> None:
    values = json.loads(json.dumps(bridge))
    change(values)
    (tmp_path / "s.json").write_text(json.dumps(values))
    found = verify_stack(read_pallet_stack(tmp_path / "s.json")).reasons
    assert (told, where) in [(reason.what, reason.where) for reason in found]
    assert not any(re.search(r"\b(inf|nan)\b", reason.detail) for reason in found)


def test_contacts_narrower_than_the_clearance_bear_nothing(tmp_path: Path) -> None:
    """A plank whose other end is 4 mm over a post, with poses that may be off by 5 mm."""
    values = {
        "format": "apc stacked pallet",
        "version": 1,
        "pallet": {"size": [0.8, 0.4], "deck": 0.1, "height": 1.0, "bears": 50.0, "walls": []},
        "clearance": 0.005,
        "placements": [
            _placed("left", [0.2, 0.4, 0.2], -0.3, 0.1, [], [-0.4, -0.2]),
            _placed("right", [0.2, 0.4, 0.2], 0.296, 0.1, [], [0.196, 0.396]),
            _placed("plank", [0.6, 0.4, 0.1], -0.1, 0.25, ["left", "right"], [-0.4, 0.2]),
        ],
        "left": [],
        "drop_test": {"sinking_m": 0.0, "shift_m": 0.0},
    }
    path = tmp_path / "s.json"
    for clearance, told in ((0.005, ["is not borne within its polygon"]), (0.003, [])):
        path.write_text(json.dumps(values | {"clearance": clearance}))
        assert [reason.what for reason in verify_stack(read_pallet_stack(path)).reasons] == told


def _placed(name: str, size: list[float], x: float, z: float, on: list[str], across: list[float]) -> Values:
    low, high = across
    return {
        "id": name, "size": size, "mass": 1.0, "bears": 2.0, "position": [x, 0.0, z], "yaw_deg": 0,
        "rests_on": on, "borne_within": [[low, -0.2], [high, -0.2], [high, 0.2], [low, 0.2]],
        "load": 0.0 if on else 1.0, "comes_down_from": 0.5,
    }  # fmt: skip


def test_a_stack_is_compared_with_its_order(tmp_path: Path) -> None:
    stack = stacked(tmp_path / "s.json", BRIDGE)
    fewer = PalletOrder(BRIDGE.pallet, BRIDGE.cartons[:3])
    more = PalletOrder(BRIDGE.pallet, (*BRIDGE.cartons, Carton("spare", (0.1, 0.1, 0.1), 1.0)))
    heavier = PalletOrder(BRIDGE.pallet, (*BRIDGE.cartons[:3], Carton("lid", LID.size, 1.5, 1.0)))
    elsewhere = PalletOrder(CONTAINERS["eur_pallet"], BRIDGE.cartons)
    for order, told in (
        (fewer, ("is not in the order", "lid")),
        (more, ("is missing", "spare")),
        (heavier, ("is not in the order", "lid")),
        (elsewhere, ("is for another pallet, clearance or fall", "the order")),
    ):
        assert [(r.what, r.where) for r in verify_stack(stack, order).reasons] == [told]


@pytest.mark.parametrize("side", ["-x", "+x", "-y", "+y"])
def test_walls_keep_cartons_away_and_stand_in_the_engine(side: str) -> None:
    """Put 15 mm into a wall, a carton is pushed out of it."""
    carton = Carton("slab", (0.2, 0.2, 0.2), 2.0)
    walled = Pallet((0.4, 0.4), 0.1, 0.5, 50.0, (side,))
    assert len(stack_as_they_come(PalletOrder(walled, (carton,) * 4)).placements) == 2
    out = (-1.0 if side[0] == "-" else 1.0) * np.array([side[1] == "x", side[1] == "y", False])
    low = np.array([-0.1, -0.1, 0.0]) + 0.115 * out
    placement = Placement(carton, low, False, (), rectangle(low[:2], low[:2] + 0.2), 0.5)
    assert drop_test(Pallet((0.4, 0.4)), (placement,)).shift < 0.001
    assert drop_test(walled, (placement,)).shift > 0.01


def test_apc_verify_tells_its_verdict(bridge: Values, tmp_path: Path) -> None:
    path, order = tmp_path / "s.json", tmp_path / "order.json"
    path.write_text(json.dumps(bridge))
    write_pallet_order(order, BRIDGE)
    answer = apc("verify", path, "--order", order, "--drop-test")
    assert answer.code == 0 and "accepted: 4 cartons" in answer.out and "drop test" in answer.out
    told = json.loads(apc("verify", path, "--json").out)
    assert told["accepted"] and told["drop_test"] is None and told["margin_m"] > 0.0
    _by(1, -0.001, 0.0, 0.0)(bridge := json.loads(json.dumps(bridge)))
    path.write_text(json.dumps(bridge))
    refused(apc("verify", path), 4, "meets another on its way down")
    misused(apc("verify", path, "--write"), "--write applies only to a plan")
    refused(apc("verify", order), 3, "is an order of a pallet")
    refused(apc("verify", order, "--order", order), 3, "is an order of a pallet")
    refused(apc("verify", tmp_path / "none.json", "--drop-test"), 3, "none.json")
