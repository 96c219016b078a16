"""Every level of reality changes what happens: none stands in a file that nothing reads."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import pickcli
from pickcli.cell.cell_file import load_cell
from pickcli.random_scenes.leaning_items import leaning_items
from pickcli.simulation import reality
from pickcli.simulation.reality import DEFAULT, Reality
from pickcli.simulation.world import World
from pickcli.trial.loop import run_trial
from pickcli.trial.played_trial import TrialConditions, TrialRequest, stowed_scene
from pickcli.trial.pose_noise import DEFAULT_NOISE, perceive
from pickcli.trial.trial_settings import TrialSettings
from support.order_builders import pick_order
from support.scripted_trial import ScriptedTrial, scene_of

CELL = load_cell("apc2016_delft")
ORDER = pick_order({"bin_A": ("crayola_24_ct", "jane_eyre_dvd")}, ("bin_A", "crayola_24_ct"))
SCENE = scene_of(ORDER, CELL)
SOURCES = [p for p in Path(pickcli.__file__).parent.rglob("*.py") if p != Path(reality.__file__)]
TEXT = "\n".join(path.read_text() for path in SOURCES)


def seen(levels: Reality) -> list[float]:
    """Where a look sees the items and the pod."""
    look = perceive(SCENE, DEFAULT_NOISE, 1, 1, levels)
    poses = [placed.T_world_item for placed in look.items] + [look.T_world_pod]
    return [float(x) for T in poses for x in T.ravel()]


def clock(levels: Reality) -> float:
    """s on the clock of a played trial."""
    return run_trial(ORDER, ScriptedTrial(SCENE).interfaces(), TrialSettings(reality=levels)).clock


def leaning(levels: Reality) -> set[str]:
    """What leans as a trial begins."""
    request = TrialRequest(ORDER, "order.json", TrialConditions(reality=levels), 1)
    return set(leaning_items(stowed_scene(request, CELL)))


def followed(levels: Reality) -> list[float]:
    """Where the joints are after 20 ms of a step of the rail."""
    home = CELL.configurations["home"]
    world = World(SCENE, home.q, home.tool_state, reality=levels, seed=1)
    world.command(home.q + 0.01 * (np.arange(8) == 0))
    for _ in range(20):
        world.step()
    q = [float(x) for x in world.q]
    world.close()
    return q


@pytest.mark.parametrize("level", [level.name for level in fields(Reality)])
def test_every_level_is_read_somewhere(level: str) -> None:
    assert re.search(rf"\breality\.{level}\b", TEXT)


@pytest.mark.parametrize(
    ("level", "value", "observed"),
    [
        ("pose_outlier_share", 1.0, seen),
        ("pod_position_error", 0.01, seen),
        ("pod_angle_error", 0.01, seen),
        ("look_time", 9.0, clock),
        ("servo", False, followed),
        ("leaning_share", 1.0, leaning),
    ],
)
def test_a_level_changes_what_happens(
    level: str, value: float, observed: Callable[[Reality], object]
) -> None:
    change: dict[str, Any] = {level: value}
    assert observed(replace(DEFAULT, **change)) != observed(DEFAULT)


def test_outliers_are_farther_off_the_larger_their_scale() -> None:
    everything_off = replace(DEFAULT, pose_outlier_share=1.0)
    assert seen(replace(everything_off, pose_outlier_scale=5.0)) != seen(everything_off)
