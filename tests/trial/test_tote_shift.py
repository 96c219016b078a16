"""A displaced tote in trials: where it stands, what the robot knows of it, and what becomes of that."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pickcli.calibration.tote_fit import TouchedPoint, fit_tote
from pickcli.calibration.tote_location import TOLERANCE, LocatedTote, Touch
from pickcli.calibration.tote_shape import tote_shape
from pickcli.calibration.touch_points import touch_points
from pickcli.cell.cell_file import load_cell
from pickcli.cell.pod_tolerance import Displacement
from pickcli.errors import InputError
from pickcli.geometry import Array, inverse, pose
from pickcli.motion.plan import Certify, Plan
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.start_state import Start
from pickcli.random_scenes.make_scene import make_scene
from pickcli.scene.scene import TOTE, PoseNoise, Scene
from pickcli.scene.scene_file import read_scene
from pickcli.simulation.guarded_move import GuardedMove
from pickcli.simulation.places import nearest_place
from pickcli.simulation.reality import DEFAULT, IDEAL
from pickcli.trial.loop import run_trial
from pickcli.trial.order import Order, OrderKind
from pickcli.trial.pose_noise import perceive
from pickcli.trial.record_schema import refuse_bad_record
from pickcli.trial.tote_shift import (
    ToteTouches,
    estimated_tote,
    felt_tote,
    refuse_touches,
    tote_stands,
    unlocated_tote,
)
from pickcli.trial.trial_clock import PLANNING_CHARGE
from pickcli.trial.trial_record import trial_record
from pickcli.trial.trial_result import TrialResult
from pickcli.trial.trial_settings import TrialSettings
from pickcli.trial.trial_summary import summary
from support.command_line import apc
from support.order_builders import pick_order
from support.page_files import document_of
from support.scripted_trial import ScriptedTrial, scene_of

CELL = load_cell("apc2016_delft")
ORDER = pick_order({"bin_A": ("crayola_24_ct",)}, ("bin_A", "crayola_24_ct"))
TASKS = Path(__file__).parents[2] / "data" / "tasks"
SHIFT = Displacement(0.012, -0.02, 0.03)
seeds = st.integers(0, 2**31 - 1)


def displaced_scene(shift: Displacement | str = SHIFT, seed: int = 0) -> Scene:
    at, _ = tote_stands(shift, DEFAULT, CELL, seed)
    assert at is not None
    return replace(scene_of(ORDER, CELL), carriers={TOTE: at})


def tote_of(scene: Scene) -> Array:
    return scene.T_world_place(CELL.places[TOTE])


@pytest.mark.parametrize(
    ("stated", "level", "is_shifted", "told"),
    [(None, False, False, False), (None, True, True, True), ("none", True, False, False),
     ("random", False, True, True), (SHIFT, True, True, False)],
)  # fmt: skip
def test_the_level_that_is_told_is_the_one_that_is_played(
    stated: Displacement | str | None, level: bool, is_shifted: bool, told: bool
) -> None:
    at, reality = tote_stands(stated, replace(DEFAULT, tote_shift=level), CELL, 3)
    assert (at is not None) == is_shifted and reality.tote_shift is told


def test_a_shift_beyond_what_touches_reach_is_refused() -> None:
    with pytest.raises(InputError, match=r"--tote-shift: 40 mm.* is beyond what touches reach"):
        tote_stands(Displacement(0.04), DEFAULT, CELL, 0)


def test_a_cell_without_a_tote_is_refused() -> None:
    with pytest.raises(InputError, match="has no tote"):
        tote_stands("random", DEFAULT, load_cell("pallet_sia20"), 0)


@given(seeds)
def test_the_true_tote_is_within_the_bounds_of_its_estimate(seed: int) -> None:
    true = displaced_scene("random", seed)
    seen = perceive(true, PoseNoise(), seed, 1, DEFAULT)
    at = seen.carriers[TOTE]
    off = inverse(tote_of(seen)) @ tote_of(true)
    assert at.error.x == DEFAULT.tote_position_error and at.error.allows(off)
    assert np.linalg.norm(off[:2, 3]) > 0.0
    again = perceive(true, PoseNoise(), seed, 2, DEFAULT).carriers[TOTE]
    np.testing.assert_array_equal(again.T_world_carrier, at.T_world_carrier)  # it is estimated once


def test_in_an_ideal_world_the_estimate_is_right() -> None:
    true = displaced_scene()
    at = estimated_tote(true, IDEAL, 4)
    np.testing.assert_allclose(at.T_world_carrier, true.carriers[TOTE].T_world_carrier, atol=1e-12)


def test_a_tote_at_its_place_is_known_as_before() -> None:
    assert not perceive(scene_of(ORDER, CELL), PoseNoise(), 1, 1, DEFAULT).carriers


def test_items_in_a_displaced_tote_are_placed_in_it() -> None:
    at, _ = tote_stands(Displacement(0.03, 0.03, 0.05), DEFAULT, CELL, 0)
    assert at is not None
    scene = make_scene({TOTE: ["dove_beauty_bar", "crayola_24_ct"]}, CELL, 2, carriers={TOTE: at})
    assert scene.carriers == {TOTE: at}
    room = CELL.places[TOTE].room
    for placed in scene.items:
        middle = (inverse(tote_of(scene)) @ placed.T_world_item)[:3, 3]
        assert (middle > room.low).all() and (middle < room.high).all()
        assert nearest_place(scene, placed.T_world_item) == TOTE


def test_a_tool_without_a_cup_does_not_touch() -> None:
    with pytest.raises(InputError, match="--locate-tote: the tool of cell apc2016_delft_pinch has no cup"):
        refuse_touches(load_cell("apc2016_delft_pinch", "fingers"), ORDER)


def test_a_tote_with_items_in_it_is_not_touched() -> None:
    order = Order(OrderKind.STOW, 2016, {}, ("crayola_24_ct",), ())
    with pytest.raises(InputError, match="--locate-tote: the tote is touched from inside, and this order"):
        refuse_touches(CELL, order)
    refuse_touches(CELL, ORDER)


@cache
def located() -> LocatedTote:
    """Touches that found the tote 0.3 mm off in x."""
    shape, T = tote_shape(CELL), tote_of(displaced_scene()) @ pose((0.0003, 0.0, 0.0))
    points = [
        TouchedPoint(aim, (T @ [*aim.point, 1.0])[:3], 1e-4, 2e-4) for aim in touch_points(shape, 8, 0.015)
    ]
    record = GuardedMove(None, np.zeros((1, 8)), np.zeros(1), 0.2, 0.012, 5.0, 1e-3)
    touches = tuple(Touch(point, record) for point in points)
    return LocatedTote(fit_tote(points, shape.T_world_tote), touches, 38.0, ())


def felt() -> ToteTouches:
    return ToteTouches(felt_tote(located(), CELL), 38.0, 8, located())


def not_felt() -> ToteTouches:
    return ToteTouches(unlocated_tote(CELL), 12.0, 8, reason="touch 1 wall left met nothing")


def play(touches: ToteTouches | None) -> tuple[TrialResult, list[Scene], list[Scene]]:
    """A trial with the tote displaced; the scenes that touches and then picks were planned in."""
    script, told, planned = ScriptedTrial(displaced_scene()), list[Scene](), list[Scene]()
    interfaces = script.interfaces()

    def touch(scene: Scene, seed: int) -> ToteTouches:
        told.append(scene)
        assert touches is not None
        return touches

    def plan(scene: Scene, query: PickQuery, start: Start, seed: int, certify: Certify) -> Plan:
        planned.append(scene)
        return script.plan(scene, query, start, seed, certify)

    settings = TrialSettings(touches_tote=touches is not None)
    result = run_trial(ORDER, replace(interfaces, locate_tote=touch, plan=plan), settings)
    return result, told, planned


def test_picks_are_planned_with_the_tote_where_it_was_felt() -> None:
    result, told, planned = play(felt())
    assert len(told) == 1 and result.items_in_tote == 1
    assert planned and all(scene.carriers[TOTE].error == felt().at.error for scene in planned)
    np.testing.assert_allclose(tote_of(planned[0]), located().estimate.T_world_tote, atol=1e-9)
    untouched, _, seen = play(None)
    assert seen[0].carriers[TOTE].error.x == DEFAULT.tote_position_error
    assert result.clock - untouched.clock == pytest.approx(38.0 + 8 * PLANNING_CHARGE)


def test_a_tote_that_no_touch_finds_may_be_anywhere_within_the_tolerance() -> None:
    result, _, planned = play(not_felt())
    assert planned[0].carriers[TOTE].error == TOLERANCE
    assert result.items_in_tote == 1
    assert any("did not locate the tote: touch 1 wall left met nothing" in line for line in summary(result))
    record = trial_record(result, "order.json", 1.0)
    assert "truly_off" not in record["tote_touches"]


def test_the_record_states_what_was_felt_and_what_was_true() -> None:
    result, _, _ = play(felt())
    record = json.loads(json.dumps(trial_record(result, "order.json", 1.0)))
    refuse_bad_record(record, "trial.json")
    assert record["tote_shift"] == {"x_mm": 12.0, "y_mm": -20.0, "yaw_deg": pytest.approx(1.718873)}
    touches = record["tote_touches"]
    assert touches["truly_off"]["x_mm"] == pytest.approx(-0.3, abs=1e-6)
    assert touches["bound"]["x_mm"] > 0.3 and len(touches["touches"]) == 8
    lines = summary(result)
    assert "the tote stood 12.0 mm, -20.0 mm and 1.72 degrees off its place" in lines
    assert "touches located the tote in 38.0 s, truly off by 0.30 mm and 0.000 degrees" in lines
    untouched, _, _ = play(None)
    assert "tote_touches" not in trial_record(untouched, "order.json", 1.0)


@pytest.mark.parametrize(
    ("change", "told"),
    [(lambda r: r["tote_touches"]["bound"].pop("x_mm"), "tote_touches.bound.x_mm: expected"),
     (lambda r: r["tote_touches"].pop("reason"), "tote_touches.reason: expected"),
     (lambda r: r["tote_shift"].update(yaw_deg="much"), "tote_shift.yaw_deg: expected")],
)  # fmt: skip
def test_a_record_with_mistakes_is_refused(change: Callable[[Any], None], told: str) -> None:
    record = json.loads(json.dumps(trial_record(play(felt())[0], "order.json", 1.0)))
    change(record)
    with pytest.raises(InputError, match=told):
        refuse_bad_record(record, "trial.json")


@pytest.mark.parametrize(
    ("options", "order", "told"),
    [(("--tote-shift", "0,0,4"), "jsk_pick_sample", "is beyond what touches reach"),
     (("--locate-tote",), "jsk_stow_sample", "this order has items in it"),
     (("--cell", "apc2016_delft_pinch", "--arm", "fingers", "--locate-tote"), "jsk_pick_sample",
      "has no cup")],
)  # fmt: skip
def test_what_cannot_be_played_is_refused_before_any_work(
    options: tuple[str, ...], order: str, told: str, tmp_path: Path
) -> None:
    for command in (("run-trial",), ("run-trials", "--seeds", "1")):
        done = apc(command[0], TASKS / f"{order}.json", *command[1:], *options, "-o", tmp_path / "out")
        assert done.code == 3 and told in done.err
        assert not (tmp_path / "out").exists()


def test_what_is_no_shift_is_a_usage_error(tmp_path: Path) -> None:
    done = apc("run-trial", TASKS / "jsk_pick_sample.json", "--tote-shift", "a,b", "-o", tmp_path / "out")
    assert done.code == 2 and "--tote-shift" in done.err


def test_a_scene_is_made_and_perceived_with_the_tote_displaced(tmp_path: Path) -> None:
    true, seen = tmp_path / "true.json", tmp_path / "seen.json"
    words = ("--in", "tote=crayola_24_ct", "--tote-shift", "-15,20,2", "--seed", "2")
    assert apc("make-scene", *words, "-o", true, "--perceived", seen).code == 0
    made, perceived = read_scene(true, CELL), read_scene(seen, CELL)
    nominal = CELL.T_world_place(CELL.places[TOTE])
    np.testing.assert_allclose((inverse(nominal) @ tote_of(made))[:2, 3], [-0.015, 0.02], atol=1e-9)
    at = perceived.carriers[TOTE]
    assert at.error.x == DEFAULT.tote_position_error
    assert at.error.allows(inverse(tote_of(perceived)) @ tote_of(made))
    assert [placed.location for placed in perceived.items] == [TOTE]


@pytest.mark.slow
def test_a_stow_out_of_a_displaced_tote_that_is_known_by_an_estimate(tmp_path: Path) -> None:
    order = json.loads((TASKS / "jsk_stow_sample.json").read_text())
    order["tote_contents"] = ["dove_beauty_bar", "crayola_24_ct"]
    order["bin_contents"] = {name: [] for name in order["bin_contents"]}
    (tmp_path / "order.json").write_text(json.dumps(order))
    words = ("--tote-shift", "25,-28,2.5", "--perception", "noise", "--seed", "3", "--json")
    done = apc("run-trial", tmp_path / "order.json", *words, "-o", tmp_path / "out")
    assert done.code == 0, done.err
    record = json.loads((tmp_path / "out" / "trial.json").read_text())
    assert record["items_in_tote"] == 2 and "tote_touches" not in record
    assert record["tote_shift"]["x_mm"] == pytest.approx(25.0)


@pytest.mark.slow
def test_a_trial_with_a_displaced_tote_that_is_touched_first(tmp_path: Path) -> None:
    """Two targets, dropped into the tote where it was felt; touches are on the clock."""
    order = json.loads((TASKS / "jsk_pick_sample.json").read_text())
    bins = {"bin_A": order["bin_contents"]["bin_A"][:1], "bin_C": order["bin_contents"]["bin_C"][:1]}
    order["bin_contents"] = {name: bins.get(name, []) for name in order["bin_contents"]}
    order["work_order"] = [{"bin": name, "item": items[0]} for name, items in bins.items()]
    (tmp_path / "order.json").write_text(json.dumps(order))
    shift = ("--tote-shift", "-25,28,-2.5", "--locate-tote", "--perception", "noise", "--seed", "3")
    done = apc("run-trial", tmp_path / "order.json", *shift, "-o", tmp_path / "out", "--json")
    assert done.code == 0, done.err
    record = json.loads((tmp_path / "out" / "trial.json").read_text())
    touches = record["tote_touches"]
    assert all(abs(touches["truly_off"][name]) <= bound for name, bound in touches["bound"].items())
    assert record["collisions"] == 0 and record["items_in_tote"] == 2
    assert record["clock_s"] > touches["duration_s"] > 20.0
    assert apc("show", tmp_path / "out", "-o", tmp_path / "trial.html").code == 0
    facts = json.dumps(document_of((tmp_path / "trial.html").read_bytes())["facts"])
    assert "shifted by -25, 28 mm" in facts and "located in" in facts
