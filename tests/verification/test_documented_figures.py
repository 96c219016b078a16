"""The figures that docs/verification.md states are those that the verifier goes by."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pickcli.verification import (
    broad_phase,
    clearance_check,
    cloud_points,
    contact_check,
    equilibrium,
    grasp_check,
    joint_limit_check,
    load_check,
    pair_distance,
    quintic,
    recovery_check,
    release_check,
    separation,
    state_sampling,
    straightness_check,
    tipping_check,
    vacuum_events,
)

PAGE = " ".join((Path(__file__).parents[2] / "docs" / "verification.md").read_text().split())
MM, DEGREE = 1e-3, np.pi / 180.0


@pytest.mark.parametrize(
    ("stated", "figure", "value"),
    [
        ("no point of arm, tool or held item moves more than 2 mm", state_sampling.MAX_STEP, 2 * MM),
        ("within 0.2 mm of the smallest distance measured", clearance_check.RESOLUTION, 0.2 * MM),
        ("finds a better one (within 0.01 mm)", separation.GAP_TOLERANCE, 0.01 * MM),
        ("for 100 mm of motion each", broad_phase.INTERVAL, 100 * MM),
        ("sixteen more are looked at there", pair_distance.FINER, 16),
        ("until the bound is within 0.1 mm of it", clearance_check.BOUND_TOLERANCE, 0.1 * MM),
        ("no nearer than 20 mm to anything that moves", cloud_points.DISTANCE_CAP, 20 * MM),
        ("by a k-d tree at states 10 mm apart", cloud_points.MAX_STATE_DISTANCE, 10 * MM),
        ("Contacts, friction (0.3) and poses", equilibrium.FRICTION, 0.3),
        ("keeps its distance at rest, to 1 mm", contact_check.PUSH_TOLERANCE, 1 * MM),
        ("on 41 by 41 vertical lines", tipping_check.N_LINES, 41),
        ("by halving, 64 times as finely", 2**tipping_check.N_HALVINGS, 64),
        ("throw at twice the speed of the cup", tipping_check.REBOUND, 2.0),
        ("(a coefficient of friction over 1)", tipping_check.MOST_FRICTION, 1.0),
        ("Only `contact` (25 mm of way at most)", straightness_check.CONTACT_WAY, 25 * MM),
        ("let go (55 mm each", straightness_check.FIRST_LIFT, 55 * MM),
        ("*d* + *e*) + 1.5 mm deep", contact_check.DEPTH_TOLERANCE, 1.5 * MM),
        (
            "(at least 0.1 mm, by which solids that just meet may measure)",
            contact_check.TOUCHING_DEPTH,
            0.1 * MM,
        ),
        ("no more than 15 mm deeper along the pod's axis", recovery_check.MAX_INWARD_DEPTH, 15 * MM),
        ("within 0.005 rad or m of it", recovery_check.OFF_PATH, 0.005),
        ("with no more than 0.02 rad or m of it left out", recovery_check.LEFT_OUT, 0.02),
        ("from above and within 1e-9", quintic.RELATIVE, 1e-9),
        ("up to 1 + 1e-6 of a limit", joint_limit_check.LIMIT_TOLERANCE, 1e-6),
        ("are straight within 2 mm and 1 degree", straightness_check.OFF_LINE, 2 * MM),
        ("are straight within 2 mm and 1 degree", straightness_check.OFF_ANGLE, DEGREE),
        ("on the item's surface (1 mm)", grasp_check.ON_SURFACE, 1 * MM),
        ("`cup_tilt`, and 1 degree)", grasp_check.ON_NORMAL, DEGREE),
        ("at the grasp (2 mm and 1 degree aside)", grasp_check.MAX_GRASP_OFFSET, 2 * MM),
        ("at the grasp (2 mm and 1 degree aside)", grasp_check.MAX_GRASP_TURN, DEGREE),
        (
            "The wrench comes from differences of the verifier's own poses 1 ms apart",
            load_check.SAMPLE_TIME,
            MM,
        ),
        ("are those (1 % and 0.01 N, Nm or share)", load_check.SAME_SHARE, 0.01),
        ("are those (1 % and 0.01 N, Nm or share)", load_check.SAME_LEAST, 0.01),
        ("the weight's torque takes 0.3 of what it bears", load_check.SLOW_TAKE_UP_TORQUE, 0.3),
        ("no joint moves by more than 1e-6 rad or m", vacuum_events.JOINT_REST_TOLERANCE, 1e-6),
        ("no farther than 5 mm from where the cup is pressed on", vacuum_events.OPENS_WITHIN, 5 * MM),
        ("within 10 mm of the release", vacuum_events.CLOSES_WITHIN, 10 * MM),
        ("moves at 0.1 m/s at most", vacuum_events.RELEASE_SPEED, 0.1),
        ("two commands at one moment (1 µs)", vacuum_events.EVENT_TIME_TOLERANCE, 1e-6),
        ("at most 0.3 m over its floor", release_check.DROP_LIMIT, 0.3),
        ("at most 20 mm and its uncertainty over the floor", release_check.SET_DOWN, 20 * MM),
    ],
)
def test_a_figure_is_what_the_page_says(stated: str, figure: float, value: float) -> None:
    assert stated in PAGE
    assert figure == pytest.approx(value, rel=1e-12)
