"""``apc show-routes``: what apc perceive would do, and does."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from pickcli.perception.items.routing import LEAST_PIXELS
from support.command_line import Made, apc, misused, refused

LOOK = ("--camera", "hand", "--at", "cam_C")


def test_the_routes_are_those_of_the_look(made: Made, tmp_path: Path) -> None:
    path = tmp_path / "p.json"
    told = apc("show-routes", "--scene", made.scene, *LOOK)
    assert told.code == 0, told.err
    assert "bin_C: 3." in told.out and "by print (all-views) and shape: " in told.out
    values = json.loads(apc("show-routes", "--scene", made.scene, *LOOK, "--json").out)
    looked = apc("perceive", "--scene", made.scene, *LOOK, "-o", path)
    assert told.out.splitlines()[1] in looked.out
    (place,), (seen,) = values["places"], json.loads(path.read_text())["places"]
    assert place["routes"] == {item["id"]: item["route"] for item in seen["items"]}
    assert place["place"] == seen["place"] and place["seen"] == seen["seen"]


@pytest.mark.parametrize(
    ("options", "why"),
    [
        (("--sift", "none"), "by shape: prints are left out"),
        (("--sift", "each-view"), "by print (each-view) and shape"),
    ],
)
def test_what_is_asked_for_overrides(made: Made, options: tuple[str, ...], why: str) -> None:
    told = apc("show-routes", "--scene", made.scene, *LOOK, *options)
    assert told.code == 0 and why in told.out


def test_a_camera_far_away_tells_how_many_pixels_are_missing() -> None:
    of = ("show-routes", "--cell", "apc2016_kth_picking", "--arm", "left", "--order", "delft_pick_2")
    told = apc(*of, "--camera", "chest", "--bin", "bin_L")
    assert told.code == 0, told.err
    assert "bin_L: 0.50 pixels per mm" in told.out
    needed = f"{LEAST_PIXELS / 25.0:.2f}"
    assert f"by shape: 0.50 pixels per mm, its print needs {needed}: oral_b_toothbrush_red" in told.out
    assert "by print (all-views) and shape: hanes_tube_socks, " in told.out


def test_bad_requests_are_one_message(made: Made) -> None:
    of = ("show-routes", "--scene", made.scene)
    misused(apc(*of, *LOOK, "--sift", "some"), "--sift", "'auto'")
    refused(apc(*of, "--camera", "hind", "--at", "cam_C"), 3, "hind", "hand")
    refused(apc(*of, *LOOK, "--bin", "bin_Z"), 3, "bin_Z")
    refused(apc(*of, "--camera", "hand", "--at", "cam_L"), 3, "shows less than")
    refused(apc("show-routes", "--cell", "apc2016_delft", *LOOK), 3, "no items are listed")
