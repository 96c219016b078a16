"""What a played trial shows, judged from the files that ``apc run-trial`` left: by its figures alone.

Contacts, limits and loads are those that the simulation measured; what became of the neighbours follows from
the true scenes before and after.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from pickcli.cell.shapes import ShapeKind
from pickcli.geometry import Array, from_quaternion

CONTACT_FORCE = 0.5  # N and
CONTACT_DEPTH = 1e-4  # m: an unplanned contact under both is a graze
OVER_PLAN = 1.1  # times the planned load on the cup
OVER_BY = 0.1  # of what the cup bears: a load that is planned at next to nothing may well be twice that

# From where a neighbour that nobody meant to move counts as moved.
CARRIED = 0.05  # m
FALLEN = 0.03  # m
TOPPLED = np.deg2rad(30.0)


@dataclass(frozen=True)
class Stood:
    """One item as a scene file has it: its place, the middle of it (3,) in m and its rotation (3, 3)."""

    location: str
    position: Array
    R: Array


@dataclass(frozen=True)
class Played:
    """One trial.

    Attributes:
        record: Content of trial.json.
        before: Items by id as they truly stood before the trial.
        after: The same afterwards; what the cup still holds is missing.
        round_ids: Ids of balls, of which a turn says nothing.
    """

    record: Mapping[str, Any]
    before: Mapping[str, Stood]
    after: Mapping[str, Stood]
    round_ids: frozenset[str]

    @property
    def executions(self) -> Iterator[Mapping[str, Any]]:
        """Everything that was carried out, in the order of time."""
        for attempt in self.record["attempts"]:
            for run in (attempt.get("parking"), attempt["execution"]):
                if run is not None:
                    yield run
            yield from (step["execution"] for step in attempt["recovery"] if step["execution"] is not None)

    @cached_property
    def contacts(self) -> list[Mapping[str, Any]]:
        """Unplanned contacts that are more than a graze."""
        return [
            c for c in self.record["contacts"] if c["force"] > CONTACT_FORCE or c["depth"] > CONTACT_DEPTH
        ]

    @cached_property
    def loads(self) -> list[tuple[float, float]]:
        """Of every hold, the planned and the simulated load on the cup, as shares of what it bears.

        Holds on whose way items may be pushed aside are left out: the load by these is not planned, only a
        reserve for it.
        """
        found = []
        for attempt in self.record["attempts"]:
            run, plan = attempt["execution"], attempt["plan"]
            planned = plan["grasp"].get("load_ratio") if plan and plan["grasp"] else None
            if plan and plan.get("pushing"):
                continue
            if run is not None and planned and run["max_load"] > 0.0:
                found.append((planned, run["max_load"]))
        return found

    @cached_property
    def neighbours_moved(self) -> dict[str, str]:
        """What happened, by id, to items that no carried out attempt was made at."""
        meant = {attempt["item"] for attempt in self.record["attempts"] if attempt["execution"] is not None}
        carried_out = [a["plan"] for a in self.record["attempts"] if a["execution"] is not None and a["plan"]]
        pushed = {name for plan in carried_out for name in plan.get("pushing", ())}
        changes = {name: self._moved(name, name in pushed) for name in self.before if name not in meant}
        return {name: what for name, what in changes.items() if what}

    def _moved(self, name: str, was_pushed: bool) -> str:
        """What happened to an item, "" if it is where it was or was nudged at most, or pushed as planned."""
        was, now = self.before[name], self.after.get(name)
        if now is None:
            return "in the cup"
        if now.location != was.location:
            return f"from {was.location} to {now.location}"
        if was_pushed:
            return ""
        up = (now.R @ was.R.T)[2, 2]  # cosine between the vertical and what was vertical in the item
        if name not in self.round_ids and up < np.cos(TOPPLED):
            return f"toppled by {np.rad2deg(np.arccos(max(-1.0, up))):.0f} degrees"
        if was.position[2] - now.position[2] > FALLEN:
            return f"fell {1000 * (was.position[2] - now.position[2]):.0f} mm"
        moved = float(np.linalg.norm(now.position - was.position))
        return f"carried along by {1000 * moved:.0f} mm" if moved > CARRIED else ""

    @property
    def n_certified(self) -> int:
        """Plans that the verifier accepted."""
        return sum(bool(a["plan"] and a["plan"]["certificate"]) for a in self.record["attempts"])

    @property
    def n_rejected(self) -> int:
        """Plans that were handed to the verifier and not accepted."""
        return sum(len(attempt["rejected"]) for attempt in self.record["attempts"])

    @property
    def delivery_times(self) -> list[float]:
        """Of every delivered target, s from leaving for its bin to its release in the tote."""
        return [
            min(start for kind, start, _ in attempt["plan"]["segments"] if kind == "depart")
            for attempt in self.record["attempts"]
            if attempt["outcome"] == "in tote"
        ]

    @property
    def event_distances(self) -> list[float]:
        """Of every fired event, m of tool path from where it was due."""
        return [event["distance"] for run in self.executions for event in run["events"]]


def read_played(folder: Path, round_names: frozenset[str]) -> Played:
    """A trial from its folder.

    Args:
        folder: Where ``apc run-trial`` wrote.
        round_names: Names of the items that are balls.
    """
    before, names = _items(folder / "scene.json")
    after, _ = _items(folder / "after.json")
    record = json.loads((folder / "trial.json").read_text())
    return Played(record, before, after, frozenset(i for i, name in names.items() if name in round_names))


def balls(items: Mapping[tuple[str, int], Any]) -> frozenset[str]:
    """Names of the items of a cell that are balls."""
    return frozenset(name for (name, _), item in items.items() if item.shape.kind is ShapeKind.SPHERE)


def _items(path: Path) -> tuple[dict[str, Stood], dict[str, str]]:
    items = json.loads(path.read_text())["items"]
    stood = {
        i["id"]: Stood(i["location"], np.array(i["position"]), from_quaternion(i["quaternion"]))
        for i in items
    }
    return stood, {i["id"]: i["name"] for i in items}
