"""Drives are judged by another algorithm: what is planned is accepted, whatever is changed is refused."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.driving.drive_plan import plan_drive
from pickcli.driving.drive_plan_file import StatedDrive, read_drive, write_drive_plan
from pickcli.driving.drive_verification import verify_drive
from pickcli.driving.driving_area import DrivingArea, FloorBox
from pickcli.driving.steering_path import SteeringPath
from support.command_line import apc, misused, refused
from support.driving_hall import HALL

AREA = DrivingArea(
    (0.0, 0.0), (10.0, 8.0), (FloorBox("rack", (5.0, 4.0), (4.0, 1.0), 0.3),),
    np.array([1.5, 1.5, 0.0]), np.array([8.5, 6.4, 3.14]), straight=-0.8,
)  # fmt: skip


@pytest.fixture(scope="module")
def drive(tmp_path_factory: pytest.TempPathFactory) -> StatedDrive:
    path = tmp_path_factory.mktemp("drive") / "drive.json"
    write_drive_plan(path, plan_drive(AREA))
    return read_drive(path)


def test_a_planned_drive_is_accepted_with_its_figures(drive: StatedDrive) -> None:
    verdict = verify_drive(drive, AREA)
    assert verdict.reasons == ()
    path = SteeringPath(AREA.truck, drive.start, drive.steps, drive.steering)
    at = np.linspace(0.0, path.length, 2000)
    corners = AREA.truck.corners
    rows = []
    for x, y, yaw in path.poses_at(at):
        turn = np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])
        edges = corners @ turn.T + (x, y)
        outline = np.concatenate(
            [np.linspace(a, b, 60) for a, b in zip(edges, np.roll(edges, -1, 0), strict=True)]
        )
        rows.append(min(AREA.boxes[0].distance(outline).min(), AREA.wall_distance(outline).min()))
    assert verdict.clearance <= min(rows) <= verdict.clearance + 0.01
    assert verdict.position_error < 1e-6 and verdict.yaw_error < 1e-6
    shares = verdict.speed_ratio, verdict.acceleration_ratio, verdict.centripetal_ratio
    assert max(shares) == pytest.approx(0.9, abs=1e-4)


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=20)
def test_its_kinematics_are_those_of_a_finer_integration(seed: int) -> None:
    """Euler's midpoint rule in steps of 0.05 mm, for any actions."""
    rng = np.random.default_rng(seed)
    steps = rng.uniform(0.05, 0.6, 6) * rng.choice([-1.0, 1.0], 6)
    steering = rng.uniform(-1.4, 1.4, 7)
    path = SteeringPath(AREA.truck, np.zeros(3), steps, steering)
    x = y = yaw = 0.0
    for step, before, after in zip(steps, steering[:-1], steering[1:], strict=True):
        n = int(np.ceil(abs(step) / 5e-5))
        for k in range(n):
            phi = before + (after - before) * (k + 0.5) / n
            middle = yaw + np.sin(phi) / AREA.truck.wheel_base * step / n / 2
            x, y = x + np.cos(phi) * np.cos(middle) * step / n, y + np.cos(phi) * np.sin(middle) * step / n
            yaw += np.sin(phi) / AREA.truck.wheel_base * step / n
    goal = np.array([x, y, yaw])
    stated = StatedDrive(
        AREA.truck, 0.05, np.zeros(3), goal, 0.0, steps, steering, np.array([0.0, path.length]), np.zeros(2),
        np.array([[0.0, 0.0, 0.0, 0.0, 0.0, steering[0]], [0.0, path.length, x, y, yaw, steering[-1]]]), 0.0,
        path.length, len(path.cusps), 1.0,
    )  # fmt: skip
    wide = replace(
        AREA, low=(-50.0, -50.0), high=(50.0, 50.0), boxes=(), start=np.zeros(3), goal=goal, straight=0.0
    )
    verdict = verify_drive(stated, wide)
    assert verdict.position_error < 1e-6 and verdict.yaw_error < 1e-6


Change = Callable[[StatedDrive], StatedDrive]
CHANGES: tuple[tuple[Change, str], ...] = (
    (lambda d: replace(d, steering=d.steering * 1.001), "does not end at the goal"),
    (lambda d: replace(d, steps=d.steps * 1.001), "does not end at the goal"),
    (lambda d: replace(d, margin=0.04), "another area: margin"),
    (lambda d: replace(d, start=d.start + 0.01), "another area: start"),
    (lambda d: replace(d, truck=replace(d.truck, width=0.7)), "another area: truck"),
    (lambda d: replace(d, speeds=d.speeds * 1.01), "beyond a limit: speed"),
    (lambda d: replace(d, speeds=np.minimum(d.speeds + 0.001, d.speeds.max())), "does not rest"),
    (lambda d: replace(d, travel=d.travel * 0.9), "speeds are not those of the whole drive"),
    (lambda d: replace(d, poses=d.poses + 1e-3), "not the same drive: poses"),
    (lambda d: replace(d, duration=d.duration - 0.1), "not the same drive: duration"),
    (lambda d: replace(d, length=d.length + 0.001), "not the same drive: travel"),
    (lambda d: replace(d, n_cusps=0), "not the same drive: cusps"),
    (lambda d: replace(d, clearance=d.clearance + 0.001), "not the same drive: clearance"),
    (lambda d: replace(d, clearance=d.clearance - 0.001), "not the same drive: clearance"),
    (lambda d: replace(d, poses=np.delete(d.poses, 30, axis=0)), "not the same drive: poses"),
    (lambda d: replace(d, poses=d.poses[:-5]), "not the same drive: poses"),
)  # fmt: skip


@pytest.mark.parametrize(("change", "told"), CHANGES)
def test_what_is_changed_is_refused(drive: StatedDrive, change: Change, told: str) -> None:
    assert told.split(":")[0] in " ".join(reason.what for reason in verify_drive(change(drive), AREA).reasons)
    assert any(told in str(reason) or told in f"{reason.what}: {reason.where}"
               for reason in verify_drive(change(drive), AREA).reasons)  # fmt: skip


@given(st.floats(1.0, 9.0), st.floats(1.0, 7.0), st.floats(-3.0, 3.0))
@settings(max_examples=40)
def test_a_box_in_the_way_is_found_whatever_lies_between_poses(
    drive: StatedDrive, x: float, y: float, yaw: float
) -> None:
    """A thin post is nearer than the margin, or is not: by distances along the truck's outline each 2 mm."""
    post = FloorBox("post", (x, y), (0.02, 0.03), yaw)
    path = SteeringPath(AREA.truck, drive.start, drive.steps, drive.steering)
    poses = path.poses_at(np.linspace(0.0, path.length, int(path.length / 0.002)))
    c, s = np.cos(poses[:, 2])[:, None], np.sin(poses[:, 2])[:, None]
    off = post.corners - poses[:, None, :2]
    along, across = c * off[..., 0] + s * off[..., 1], c * off[..., 1] - s * off[..., 0]
    truck = AREA.truck
    beyond = np.maximum(np.maximum(along - truck.front, -truck.back - along), 0.0)
    aside = np.maximum(np.abs(across) - truck.width / 2, 0.0)
    least = float(np.hypot(beyond, aside).min())
    found = verify_drive(drive, replace(AREA, boxes=(post,))).reasons
    met = [reason for reason in found if reason.where != "clearance"]  # it was planned beside the rack
    if least < AREA.margin - 0.005:
        assert [reason.what for reason in met] == ["too near"] and "post" in met[0].detail
    if least > AREA.margin + 0.005:
        assert not met


def test_apc_verify_tells_its_verdict(tmp_path: Path) -> None:
    hall, path = tmp_path / "hall.yaml", tmp_path / "drive.json"
    hall.write_text(HALL)
    assert apc("plan-drive", hall, "-o", path).code == 0
    told = apc("verify", path, "--area", hall)
    assert told.code == 0 and "accepted: a drive to the goal" in told.out and told.err == ""
    answer = json.loads(apc("verify", path, "--area", hall, "--json").out)
    assert answer["accepted"] and answer["clearance"] >= 0.05
    misused(apc("verify", path), "name its driving area with --area")
    misused(
        apc("verify", path, "--area", hall, "--drop-test"), "--drop-test applies only to a stacked pallet"
    )
    refused(apc("verify", path, "--area", path), 3, "is a plan of a drive, but a driving area is expected")
    hall.write_text(HALL.replace("centre: [4, 4], size: [2, 1]", "centre: [3.5, 1.6], size: [0.2, 0.2]"))
    refused(apc("verify", path, "--area", hall), 4, "too near", "rack")


def test_a_drive_into_a_pallet_is_judged_by_where_that_was_detected(tmp_path: Path) -> None:
    dock, seen, path = tmp_path / "dock.yaml", tmp_path / "seen.json", tmp_path / "into.json"
    dock.write_text(
        "format: apc driving area\nversion: 1\nwalls: {low: [0, 0], high: [9, 7]}\n"
        "start: {position: [6.5, 2.2], yaw: 0.3}\n"
        "pallet: {position: [2, 3.5], yaw: 0.1, load: 0.5, off: [0.03, -0.05, 0.04]}\n"
    )
    assert apc("detect-pallet", dock, "--at", 4.0, 3.6, 0.1, "--seed", 3, "-o", seen).code == 0
    assert apc("plan-drive", dock, "--detected", seen, "-o", path).code == 0
    assert apc("verify", path, "--area", dock, "--detected", seen).code == 0
    refused(apc("verify", path, "--area", dock), 4, "does not end at the goal")


def _without_a_step(values: dict[str, Any]) -> None:
    values["actions"]["steps"].pop()


def _standing(values: dict[str, Any]) -> None:
    values["actions"]["steps"][2] = 0.0


def _back_in_travel(values: dict[str, Any]) -> None:
    values["profile"]["travel"][3] = 0.0


def _too_few_speeds(values: dict[str, Any]) -> None:
    values["profile"]["speed"].pop()


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (_without_a_step, "actions.steering"),
        (_standing, "actions.steps[2]: a step of no travel"),
        (_back_in_travel, "profile.travel: does not increase"),
        (_too_few_speeds, "profile.speed"),
    ],
)  # fmt: skip
def test_mistakes_of_a_file_are_told(
    drive: StatedDrive, change: Callable[[dict[str, Any]], None], told: str, tmp_path: Path
) -> None:
    hall, path = tmp_path / "hall.yaml", tmp_path / "drive.json"
    hall.write_text(HALL)
    write_drive_plan(path, plan_drive(AREA))
    values = json.loads(path.read_text())
    change(values)
    path.write_text(json.dumps(values))
    refused(apc("verify", path, "--area", hall), 3, told)
