"""What a played trial is judged by: contacts, loads, and neighbours that nobody meant to move."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bench.played import Played, Stood, read_played
from pickcli.geometry import rotation_axis_angle

BOOK = Stood("bin_A", np.array([0.3, 0.1, 1.0]), np.eye(3))
X, Z = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)


def run(**changes: Any) -> dict[str, Any]:
    return {"collisions": [], "events": [], "max_load": 0.0, **changes}


def attempt(item: str = "target", **changes: Any) -> dict[str, Any]:
    default: dict[str, Any] = {
        "outcome": "in tote",
        "plan": None,
        "rejected": [],
        "execution": None,
        "recovery": [],
    }
    return {"item": item, **default, **changes}


def step(execution: dict[str, Any] | None) -> dict[str, Any]:
    return {"what": "out", "reason": "", "execution": execution}


def planned(load_ratio: float | None, certificate: object = "yes") -> dict[str, Any]:
    grasp = {"kind": "top"} if load_ratio is None else {"kind": "top", "load_ratio": load_ratio}
    segments = [["transit", 0.0, 1.0], ["place", 3.0, 4.5], ["depart", 4.5, 5.0]]
    return {"grasp": grasp, "certificate": certificate, "segments": segments}


def played(
    *attempts: dict[str, Any], now: Stood | None = BOOK, is_round: bool = False, contacts: Any = ()
) -> Played:
    """A trial in which a book stood beside the target, and stands ``now`` where it is afterwards."""
    after = {} if now is None else {"book": now}
    return Played(
        {"attempts": list(attempts), "contacts": list(contacts)},
        {"book": BOOK},
        after,
        frozenset({"book"} if is_round else ()),
    )


@pytest.mark.parametrize(
    ("force", "depth", "counts"),
    [(0.4, 0.00005, False), (0.6, 0.0, True), (0.0, 0.0002, True), (0.5, 0.0001, False)],
)
def test_contacts_count_from_a_force_or_a_depth(force: float, depth: float, counts: bool) -> None:
    touched = {"a": "lance", "b": "book", "force": force, "depth": depth}
    assert bool(played(attempt(), contacts=[touched]).contacts) == counts


def test_neighbours_that_stay_or_are_nudged_are_not_named() -> None:
    nudged = replace(
        BOOK, position=BOOK.position + np.array([0.02, 0.0, -0.01]), R=rotation_axis_angle(Z, 1.0)
    )
    assert played(attempt()).neighbours_moved == {}
    assert played(attempt(), now=nudged).neighbours_moved == {}


@pytest.mark.parametrize(
    ("now", "told"),
    [
        (replace(BOOK, location="outside"), "from bin_A to outside"),
        (replace(BOOK, R=rotation_axis_angle(X, np.pi / 2)), "toppled by 90 degrees"),
        (replace(BOOK, R=rotation_axis_angle(X, np.pi)), "toppled by 180 degrees"),
        (replace(BOOK, position=BOOK.position - [0.0, 0.0, 0.04]), "fell 40 mm"),
        (replace(BOOK, position=BOOK.position + np.array([0.06, 0.0, 0.0])), "carried along by 60 mm"),
        (None, "in the cup"),
    ],
)
def test_neighbours_that_moved_are_named_with_what_happened(now: Stood | None, told: str) -> None:
    assert played(attempt(), now=now).neighbours_moved == {"book": told}


def test_what_a_carried_out_attempt_was_made_at_is_no_neighbour() -> None:
    gone = replace(BOOK, location="tote")
    assert played(attempt("book", execution=run()), now=gone).neighbours_moved == {}
    assert played(attempt("book", outcome="no plan"), now=gone).neighbours_moved == {
        "book": "from bin_A to tote"
    }


def test_a_ball_may_turn_but_not_roll_away() -> None:
    turned = replace(BOOK, R=rotation_axis_angle(X, 1.0))
    assert played(attempt(), now=turned, is_round=True).neighbours_moved == {}
    rolled = replace(turned, position=BOOK.position + np.array([0.0, 0.2, 0.0]))
    assert played(attempt(), now=rolled, is_round=True).neighbours_moved == {
        "book": "carried along by 200 mm"
    }


def test_loads_are_those_of_every_hold_and_its_plan() -> None:
    shown = played(
        attempt(plan=planned(0.5), execution=run(max_load=0.6)),
        attempt(plan=planned(0.5), execution=run()),  # nothing was held
        attempt(plan=planned(None), execution=run(max_load=0.6)),  # a plan that states no load
        attempt(outcome="rejected", rejected=[[{"what": "too close"}]]),
    )
    assert shown.loads == [(0.5, 0.6)]
    assert (shown.n_certified, shown.n_rejected) == (3, 1)


def test_delivery_ends_with_the_release() -> None:
    assert played(attempt(plan=planned(0.5)), attempt(outcome="no plan")).delivery_times == [4.5]


def test_event_distances_are_those_of_recoveries_too() -> None:
    fired = run(events=[{"distance": 0.001}])
    assert played(attempt(execution=fired, recovery=[step(fired), step(None)])).event_distances == [
        0.001,
        0.001,
    ]


def test_read_played_reads_what_a_trial_wrote(tmp_path: Path) -> None:
    item = {
        "id": "ball#2",
        "name": "ball",
        "location": "bin_B",
        "position": [1.0, 2.0, 3.0],
        "quaternion": [0, 0, 0, 1],
    }
    (tmp_path / "scene.json").write_text(json.dumps({"items": [item]}))
    (tmp_path / "after.json").write_text(json.dumps({"items": []}))
    (tmp_path / "trial.json").write_text(json.dumps({"attempts": []}))
    shown = read_played(tmp_path, frozenset({"ball"}))
    assert shown.round_ids == {"ball#2"}
    assert shown.before["ball#2"].location == "bin_B"
    assert shown.neighbours_moved == {"ball#2": "in the cup"}


def test_what_was_to_be_pushed_may_be_anywhere_in_its_place() -> None:
    pushing = {"grasp": None, "certificate": None, "pushing": ["book"]}
    turned = replace(BOOK, R=rotation_axis_angle(X, np.pi / 2))
    gone = replace(BOOK, location="outside")
    for execution, now, found in (
        (run(), turned, {}),
        (run(), gone, {"book": "from bin_A to outside"}),
        (None, turned, {"book": "toppled by 90 degrees"}),
    ):
        assert played(attempt(execution=execution, plan=pushing), now=now).neighbours_moved == found
