"""How the lengths of the first stretch of a lift relate."""

from __future__ import annotations

from pickcli.planning.pick_settings import DEFAULTS
from pickcli.planning.stages.tool_clearance import TOOL_SWING
from pickcli.random_scenes.extraction_access import FIRST_STRETCH
from pickcli.verification.straightness_check import FIRST_LIFT


def test_the_verifier_allows_a_longer_first_stretch_than_the_planner_and_stowing_a_shorter_one() -> None:
    assert FIRST_STRETCH <= DEFAULTS.first_stretch < DEFAULTS.first_stretch + TOOL_SWING < FIRST_LIFT
