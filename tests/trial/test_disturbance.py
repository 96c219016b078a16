"""What moved without being meant to is named, with how far; what was hit too hard counts as damage."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pickcli.cell.cell_file import load_cell
from pickcli.geometry import Array, pose
from pickcli.scene.scene import TOTE, Scene
from pickcli.simulation.contacts import Collision
from pickcli.simulation.places import OUTSIDE
from pickcli.simulation.reality import DEFAULT
from pickcli.trial.damage import FRAGILE_LIMITS, ITEM_LIMITS, SHELF, SHELF_LIMITS, Damage, damages
from pickcli.trial.disturbance import MAX_SETTLING, DisturbanceKind, disturbances
from pickcli.trial.loop import run_trial
from pickcli.trial.trial_interfaces import ExecutionResult
from pickcli.trial.trial_record import trial_record
from pickcli.trial.trial_result import TrialResult
from pickcli.trial.trial_settings import TrialSettings
from pickcli.trial.trial_summary import summary
from support.order_builders import pick_order
from support.scripted_trial import ScriptedTrial, scene_of

ORDER = pick_order(
    {"bin_A": ("crayola_24_ct", "dove_beauty_bar", "oreo_mega_stuf")}, ("bin_A", "crayola_24_ct")
)
SCENE = scene_of(ORDER, load_cell("apc2016_delft"))
BAR = "dove_beauty_bar"


def after(T: Array, location: str = "bin_A") -> Scene:
    """The soap bar displaced in the world."""
    bar = SCENE.find(BAR)
    return SCENE.moved(replace(bar, T_world_item=T @ bar.T_world_item, location=location))


def about_itself(rpy: tuple[float, float, float]) -> Array:
    centre = SCENE.find(BAR).T_world_item[:3, 3]
    return pose(centre) @ pose((0.0, 0.0, 0.0), rpy=rpy) @ pose(-centre)


@pytest.mark.parametrize(
    ("T", "location", "kind"),
    [
        (pose((0.02, 0.0, 0.0)), "bin_A", DisturbanceKind.PUSHED),
        (pose((0.0, 0.15, 0.0)), "bin_A", DisturbanceKind.CARRIED),
        (pose((0.0, 0.02, 0.0)), "bin_B", DisturbanceKind.CARRIED),
        (about_itself((1.5, 0.0, 0.0)), "bin_A", DisturbanceKind.TOPPLED),
        (about_itself((0.0, 0.0, 1.5)), "bin_A", DisturbanceKind.PUSHED),
        (pose((-0.6, 0.0, -1.2)), OUTSIDE, DisturbanceKind.FELL),
    ],
)
def test_each_kind_has_its_name_and_how_far(T: Array, location: str, kind: DisturbanceKind) -> None:
    (found,) = disturbances(SCENE, after(T, location), (), 0.3)
    assert (found.item, found.kind, found.out_of, found.into) == (BAR, kind, "bin_A", location)
    shift = after(T).find(BAR).T_world_item[:3, 3] - SCENE.find(BAR).T_world_item[:3, 3]
    assert found.moved == pytest.approx(np.linalg.norm(shift))
    if kind is DisturbanceKind.FELL:
        assert found.fell == pytest.approx(1.2)


@given(st.floats(0.0, 0.9 * MAX_SETTLING), st.floats(-3.1, 3.1))
def test_what_only_settles_anew_is_not_named(distance: float, way: float) -> None:
    T = pose((distance * np.cos(way), distance * np.sin(way), 0.0))
    assert disturbances(SCENE, after(T), (), 0.3) == ()


def test_what_was_meant_to_move_and_what_is_in_the_cup_is_left_out() -> None:
    away = after(pose((-1.0, 0.0, -0.5)), OUTSIDE)
    assert disturbances(SCENE, away, {BAR}, 0.3) == ()
    assert disturbances(SCENE.without(BAR), away, (), 0.3) == ()
    assert disturbances(SCENE, SCENE.without(BAR), (), 0.3) == ()


def hit(a: str, b: str, force: float) -> Collision:
    return Collision(a, b, 0.0, 0.1, 0.001, (0.0, 0.0, 0.0), force)


@pytest.mark.parametrize("limits", [ITEM_LIMITS, SHELF_LIMITS, FRAGILE_LIMITS])
def test_damage_begins_over_the_limit(limits) -> None:  # type: ignore[no-untyped-def]
    grades = [
        limits.grade(force) for force in (limits.minor, limits.minor + 1, limits.major, limits.major + 1)
    ]
    assert grades == [None, Damage.MINOR, Damage.MINOR, Damage.MAJOR]


def test_every_item_and_the_shelf_is_damaged_once_by_the_worst_hit() -> None:
    shelf = SCENE.cell.pod.bodies[0].name
    other = SCENE.cell.pod.bodies[1].name
    found = damages(
        SCENE,
        [
            hit("lance", BAR, 600.0), hit("cup", BAR, 200.0), hit("crayola_24_ct", BAR, 160.0),
            hit("lance", shelf, 600.0), hit("link_b", other, 700.0), hit("lance", "oreo_mega_stuf", 60.0),
            hit("lance", "table", 9000.0),
        ],
    )  # fmt: skip
    assert dict(found) == {
        BAR: Damage.MAJOR, SHELF: Damage.MINOR, "oreo_mega_stuf": Damage.MINOR, "crayola_24_ct": Damage.MINOR
    }  # fmt: skip


def played(execution: ExecutionResult, **levels: Any) -> TrialResult:
    fake = ScriptedTrial(SCENE, executions={"crayola_24_ct": [execution]}, collided=execution.collisions)
    return run_trial(ORDER, fake.interfaces(), TrialSettings(reality=replace(DEFAULT, **levels)))


def test_the_fall_of_a_neighbour_and_damage_cost_what_the_rules_say() -> None:
    (fall,) = disturbances(SCENE, after(pose((-0.6, 0.0, -1.2)), OUTSIDE), (), 0.3)
    execution = ExecutionResult(4.0, "contact", collisions=(hit("lance", BAR, 200.0),), disturbed=(fall,))
    result = played(execution)
    costs = {(line.subject, line.points) for line in result.score.lines if line.points < 0}
    assert costs == {(BAR, -5)}  # twice: it fell, and it was hit
    assert sum(line.points for line in result.score.lines if line.points < 0) == -10
    record = trial_record(result, "order.json", 1.0)
    assert record["disturbed"] == 1 and record["damages"] == [[BAR, "minor"]]
    (named,) = record["attempts"][0]["execution"]["disturbed"]
    assert named["item"] == BAR and named["kind"] == "fell" and named["fell"] == pytest.approx(1.2)
    assert any(BAR in line and "fell" in line for line in summary(result))


def test_what_falls_during_the_last_look_costs_the_same_and_is_told_apart() -> None:
    (fall,) = disturbances(SCENE, after(pose((-0.6, 0.0, -1.2)), OUTSIDE), (), 0.3)
    result = run_trial(ORDER, ScriptedTrial(SCENE, disturbed_last=(fall,)).interfaces())
    assert [(line.subject, line.points) for line in result.score.lines if line.points < 0] == [(BAR, -5)]
    record = trial_record(result, "order.json", 1.0)
    assert record["disturbed"] == 1
    assert [(d["item"], d["kind"]) for d in record["disturbed_last"]] == [(BAR, "fell")]
    assert record["attempts"] and not any(e["execution"]["disturbed"] for e in record["attempts"])
    assert any(BAR in line and "fell" in line for line in summary(result))


def test_a_contact_counts_once_and_by_what_it_came_to_after_the_motion() -> None:
    told = hit("lance", BAR, 60.0)  # as the execution tells it; it grew while the robot waited
    fake = ScriptedTrial(
        SCENE, executions={"crayola_24_ct": [ExecutionResult(4.0, "contact", collisions=(told,))]}
    )
    fake.executions["recover as planned"] = [ExecutionResult(4.0, collisions=(told,))]
    fake.collided = (replace(told, t_end=8.0, force=600.0), hit("cup", "oreo_mega_stuf", 1.0))
    result = run_trial(ORDER, fake.interfaces())
    assert result.n_collisions == 2 and result.final.damages == ((BAR, Damage.MAJOR),)
    record = trial_record(result, "order.json", 1.0)
    assert record["collisions"] == 2 == len(record["contacts"])
    assert [contact["force"] for contact in record["contacts"]] == [600.0, 1.0]


def test_damage_can_be_switched_off() -> None:
    result = played(
        ExecutionResult(4.0, "contact", collisions=(hit("lance", BAR, 200.0),)), damage_limits=False
    )
    assert result.final.damages == ()


def test_what_lies_in_the_tote_is_pushed_by_what_is_let_go_over_it() -> None:
    lying = after(pose((0.0, 0.0, 0.0)), TOTE)
    pushed = lying.moved(replace(lying.find(BAR), T_world_item=pose((0.05, 0.0, 0.0))))
    assert disturbances(lying, pushed, (), 0.3) == ()
