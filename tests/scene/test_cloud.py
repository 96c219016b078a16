"""Clouds of a scene: read with care, kept away from by plans, and proven by the verifier's own derivation."""

from __future__ import annotations

import json
import zipfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.errors import InputError, NoPlanError
from pickcli.geometry import Array, pose, transform_points
from pickcli.motion.plan import Plan
from pickcli.planning.move import MoveGoal, plan_move
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.scene.cloud import Cloud
from pickcli.scene.cloud_file import read_points
from pickcli.scene.scene import PoseNoise, Scene
from pickcli.scene.scene_file import read_scene, scene_hash, write_scene
from pickcli.verification.cloud_points import DISTANCE_CAP, near_points
from pickcli.verification.fcl_solids import Solid
from pickcli.verification.moving_parts import parts_of_segments
from pickcli.verification.verify import sampled, verify
from support.other_robots import write_robot

POINTS = np.random.default_rng(0).uniform(-1.0, 1.0, (50, 3)).round(3)
Refused = Callable[[Callable[[], object]], str]


@pytest.fixture(scope="module")
def branching(tmp_path_factory: pytest.TempPathFactory) -> Cell:
    return load_cell(write_robot(tmp_path_factory.mktemp("branching")))


def ply(form: str, points: Array) -> bytes:
    """A PLY file with a colour beside each point, and faces after them."""
    head = (
        f"ply\nformat {form} 1.0\ncomment made up\nelement vertex {len(points)}\nproperty float x\n"
        "property float y\nproperty float z\nproperty uchar red\nelement face 0\n"
        "property list uchar int vertex_indices\nend_header\n"
    )
    if form == "ascii":
        body = "\n".join(" ".join(map(str, [*row, 7])) for row in points.tolist()).encode()
    else:
        order = "<" if "little" in form else ">"
        rows = np.zeros(len(points), [(axis, f"{order}f4") for axis in "xyz"] + [("red", "u1")])
        for k, axis in enumerate("xyz"):
            rows[axis] = points[:, k]
        body = rows.tobytes()
    return head.encode() + body


def written(folder: Path, suffix: str, form: str = "ascii") -> Path:
    path = folder / f"cloud.{suffix}"
    if suffix == "npy":
        np.save(path, POINTS)
    elif suffix == "npz":
        np.savez(path, points=POINTS, colours=np.zeros(50))
    else:
        path.write_bytes(ply(form, POINTS))
    return path


@pytest.mark.parametrize(
    ("suffix", "form"),
    [
        ("npy", ""),
        ("npz", ""),
        *(("ply", f"binary_{end}_endian") for end in ("little", "big")),
        ("ply", "ascii"),
    ],
)
def test_every_kind_of_file_holds_the_same_points(tmp_path: Path, suffix: str, form: str) -> None:
    np.testing.assert_allclose(read_points(written(tmp_path, suffix, form)), POINTS, atol=1e-6)


@pytest.mark.parametrize(
    ("name", "content", "problem"),
    [
        ("a.npy", b"\x93NUMPY\x01", "is no NPY cloud that can be read"),
        ("a.npy", None, "no such file; the scene names it as its cloud"),
        ("a.xyz", b"1 2 3", "expected a cloud in .npy, .npz, .ply"),
        ("a.ply", b"", "its header is not that of a PLY file"),
        ("a.ply", ply("binary_little_endian", POINTS)[:-5], "is no PLY cloud that can be read"),
        ("a.ply", ply("binary_middle_endian", POINTS), "is no PLY cloud that can be read"),
        ("a.ply", ply("ascii", POINTS).replace(b"vertex 50", b"vertex 9000000"), "it has 9000000 points"),
        ("a.ply", ply("ascii", POINTS)[:-200], "of the 50 points that its header states"),
        ("a.ply", ply("ascii", POINTS).replace(b"float z", b"float w"), "its vertices have no z; write"),
        ("a.ply", ply("ascii", POINTS[:0]), "has 0 points; .*: leave the cloud out"),
        ("a.npz", b"PK\x03\x04", "is no NPZ cloud that can be read"),
    ],
)
def test_what_is_no_cloud_is_refused(tmp_path: Path, name: str, content: bytes | None, problem: str) -> None:
    if content is not None:
        (tmp_path / name).write_bytes(content)
    with pytest.raises(InputError, match=problem):
        read_points(tmp_path / name)


@pytest.mark.parametrize(
    ("points", "problem"),
    [
        (np.zeros((4, 2)), r"expected numbers of shape \(N, 3\), got float64 \(4, 2\)"),
        (np.zeros((0, 3)), "has 0 points"),
        (np.array([["a", "b", "c"]]), "expected numbers"),
        (np.array([None, None, None]), "cannot be loaded when allow_pickle=False"),
    ],
)
def test_points_that_are_none_are_refused(tmp_path: Path, points: Array, problem: str) -> None:
    np.save(tmp_path / "a.npy", points)
    with pytest.raises(InputError, match=problem):
        read_points(tmp_path / "a.npy")


@pytest.mark.parametrize(
    ("points", "problem"),
    [
        (np.zeros((0, 3)), r"cloud\.npy: expected points of shape \(N, 3\), got \(0, 3\)"),
        (np.array([[0.0, np.nan, 0.0], [0.0, 0.0, 0.0]]), "1 points are not finite; leave them out"),
        (
            np.array([[0.0, 1500.0, 0.0]]),
            "reaches 1500 m far, expected 100 at most; lengths are in m, not mm",
        ),
        (np.array([[0.0, 40.0, 0.0], [9.0, 50.0, 10.0]]), "over 45 m from the sensor, .*; lengths are in m"),
    ],
)
def test_what_are_no_points_around_a_robot_is_refused(points: Array, problem: str) -> None:
    with pytest.raises(InputError, match=problem):
        Cloud(Path("cloud.npy"), np.eye(4), points, 0.004, 0.002)


def test_an_archive_that_unpacks_to_too_much_is_refused(tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / "a.npz", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("points.npy", b"\0" * 70_000_000)
    with pytest.raises(InputError, match="it unpacks to 70000000 bytes, expected 64000000 at most"):
        read_points(tmp_path / "a.npz")


def scene_of(cell: Cell, cloud: Cloud | None = None) -> Scene:
    return Scene(cell, cell.T_world_pod, (), PoseNoise(0.0, 0.0), cloud=cloud)


def test_a_scene_refers_to_its_cloud_and_its_hash_covers_it(branching: Cell, tmp_path: Path) -> None:
    T = pose((0.1, 0.2, 0.3), rpy=(0.0, 0.1, 1.0))
    (tmp_path / "clouds").mkdir()
    scene = scene_of(branching, Cloud(written(tmp_path / "clouds", "npy"), T, POINTS, 0.004, 0.002))
    write_scene(scene, tmp_path / "scene.json")
    assert json.loads((tmp_path / "scene.json").read_text())["cloud"]["file"] == "clouds/cloud.npy"
    again = read_scene(tmp_path / "scene.json", branching)
    assert again.cloud is not None
    np.testing.assert_allclose(again.cloud.points, transform_points(T, POINTS), atol=1e-9)
    assert (again.cloud.radius, again.cloud.error) == (0.004, 0.002)
    assert scene_hash(again) == scene_hash(scene)
    cloud = again.cloud
    others = [None, replace(cloud, radius=0.005), replace(cloud, error=0.0), replace(cloud, measured=-POINTS)]
    others.append(replace(cloud, T_world_sensor=np.eye(4)))
    assert len({scene_hash(scene_of(branching, other)) for other in [cloud, *others]}) == 6


def test_a_cloud_that_is_not_there_is_told_with_its_place(
    branching: Cell, tmp_path: Path, refused: Refused
) -> None:
    scene = scene_of(branching, Cloud(tmp_path / "gone.npy", np.eye(4), POINTS, 0.004, 0.0))
    write_scene(scene, tmp_path / "scene.json")
    message = refused(lambda: read_scene(tmp_path / "scene.json", branching))
    assert "cloud.file: " in message and "gone.npy: no such file" in message


def wall(spacing: float = 0.02) -> Cloud:
    """A wall of points beside the axis of the robot, in the way of its lower arm from home to away."""
    angle = 2.6
    r, z = np.meshgrid(np.arange(0.12, 0.5, spacing), np.arange(1.75, 2.2, spacing))
    points = np.column_stack([r.ravel() * np.cos(angle), r.ravel() * np.sin(angle), z.ravel()])
    return Cloud(Path("wall.npy"), pose((-1.2, 0.2, 0.0)), points, spacing / 2, 0.001)


def move(scene: Scene) -> Plan:
    cell = scene.cell
    home, away = cell.configurations["home"], cell.configurations["away"]
    return plan_move(PlanningContext(cell), scene, Start(home.q, home.tool_state), MoveGoal(away.q), seed=1)


def test_a_plan_leads_around_a_cloud_and_is_proven(branching: Cell) -> None:
    scene = scene_of(branching, wall())
    plan = move(scene)
    verdict = verify(plan, scene)
    assert verdict.certificate is not None, verdict.reasons
    assert branching.clearance - 1e-4 <= verdict.certificate.min_clearance <= DISTANCE_CAP


def test_the_verifier_refuses_what_was_planned_without_the_cloud(branching: Cell) -> None:
    scene = scene_of(branching, wall())
    plan = replace(move(scene_of(branching)), scene_hash=scene_hash(scene))
    reasons = verify(plan, scene).reasons
    assert reasons and all("point of the cloud at (" in str(reason) for reason in reasons)


def test_a_goal_in_a_cloud_is_told_with_the_point(branching: Cell) -> None:
    context, away = PlanningContext(branching), branching.configurations["away"]
    tip = context.arm.tip(away.q, away.tool_state)[:3, 3]
    scene = scene_of(branching, Cloud(Path("one.npy"), np.eye(4), tip[None], 0.01, 0.0))
    x, y, z = tip.tolist()
    with pytest.raises(NoPlanError) as error:
        move(scene)
    assert f"cup against cloud point at ({x:.3f}, {y:.3f}, {z:.3f})" in str(error.value)


def test_every_point_that_comes_near_is_found(branching: Cell) -> None:
    """Against the exact distance of all points from all parts in all states."""
    points = np.random.default_rng(1).uniform((-1.8, -0.5, 0.9), (-0.5, 0.9, 2.2), (300, 3))
    cloud = Cloud(Path("some.npy"), np.eye(4), points, 0.002, 0.001)
    plan, scene = move(scene_of(branching)), scene_of(branching, cloud)
    moving, ball = parts_of_segments(plan, scene, None), Solid(Shape(ShapeKind.SPHERE, (0.002,)))
    states = sampled(plan, scene, moving)
    found = near_points(plan, scene, states, moving).fixtures
    places = {tuple(fixture.T_world_shape[:3, 3].tolist()) for fixture in found}
    others = [point for point in points if tuple(point.tolist()) not in places]
    assert found and others
    for i in range(0, len(states.times), 25):
        for part in (part for part in moving[0] if part.reach.any()):
            part.solid.place(states.links[part.link, i] @ part.T_link_shape)
            middle = (states.links[part.link, i] @ part.T_link_shape)[:3, 3]
            for point in others:
                if np.linalg.norm(point - middle) < 0.3:
                    ball.place(pose(point))
                    assert part.solid.distance(ball) > DISTANCE_CAP + cloud.error
