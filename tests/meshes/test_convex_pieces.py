"""Convex pieces of meshes: they contain the surface, and are cut where that saves volume."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from pickcli.errors import InputError
from pickcli.geometry import Array
from pickcli.meshes.convex_pieces import MAX_PIECES, convex_pieces
from pickcli.meshes.mesh_file import parse_triangles
from pickcli.meshes.mesh_pieces import mesh_pieces


def boxes(*bounds: tuple[tuple[float, float, float], tuple[float, float, float]]) -> Array:
    """Triangles of axis-aligned boxes, each from a lower to an upper corner."""
    found = []
    for low, high in bounds:
        corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
        corners = np.array(low) + corners * (np.array(high) - np.array(low))
        found.append(corners[ConvexHull(corners).simplices])
    return np.concatenate(found)


ELBOW = boxes(((0, 0, 0), (0.3, 0.1, 0.1)), ((0, 0, 0), (0.1, 0.1, 0.4)))


def outside(pieces: tuple[Array, ...], points: Array) -> float:
    """m, how far the farthest point is outside of all pieces."""
    planes = [ConvexHull(piece).equations for piece in pieces]
    away = [(points @ p[:, :3].T + p[:, 3]).max(axis=1) for p in planes]
    return float(np.min(away, axis=0).max())


def surface_points(triangles: Array, seed: int = 0, n: int = 2000) -> Array:
    rng = np.random.default_rng(seed)
    chosen = triangles[rng.integers(0, len(triangles), n)]
    return np.asarray(np.einsum("nk,nkc->nc", rng.dirichlet(np.ones(3), n), chosen))


def test_a_convex_mesh_is_one_piece() -> None:
    assert len(convex_pieces(boxes(((0, 0, 0), (0.3, 0.2, 0.1))))) == 1


def test_an_elbow_is_cut_where_its_arms_part() -> None:
    pieces = convex_pieces(ELBOW)
    volume = sum(ConvexHull(piece).volume for piece in pieces)
    assert 2 <= len(pieces) <= MAX_PIECES
    assert volume <= 1.1 * (0.3 * 0.1 * 0.1 + 0.1 * 0.1 * 0.3)
    assert ConvexHull(ELBOW.reshape(-1, 3)).volume > 1.4 * volume


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_the_pieces_contain_any_mesh(seed: int) -> None:
    """A soup of triangles, closed or not."""
    rng = np.random.default_rng(seed)
    triangles = rng.uniform(-0.4, 0.4, (30, 1, 3)) + rng.normal(scale=0.1, size=(30, 3, 3))
    assert outside(convex_pieces(triangles), surface_points(triangles, seed)) < 1e-9


def stl(triangles: Array) -> bytes:
    """Binary STL."""
    rows = [struct.pack("<12fH", 0, 0, 0, *triangle.ravel(), 0) for triangle in triangles]
    return bytes(80) + struct.pack("<I", len(rows)) + b"".join(rows)


def ascii_stl(triangles: Array) -> bytes:
    facets = "".join(
        "facet normal 0 0 0\nouter loop\n"
        + "".join("vertex {} {} {}\n".format(*corner) for corner in triangle)
        + "endloop\nendfacet\n"
        for triangle in triangles
    )
    return f"solid elbow\n{facets}endsolid elbow\n".encode()


def obj(triangles: Array) -> bytes:
    corners = "".join("v {} {} {}\n".format(*corner) for corner in triangles.reshape(-1, 3))
    faces = "".join(f"f {3 * k + 1} {3 * k + 2} {3 * k + 3}\n" for k in range(len(triangles)))
    return f"mtllib ../../elsewhere.mtl\n{corners}{faces}".encode()


def collada(triangles: Array, metres: float) -> bytes:
    numbers = " ".join(map(str, triangles.ravel()))
    n = 3 * len(triangles)
    return f"""<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><created>2016-07-01T00:00:00</created><modified>2016-07-01T00:00:00</modified>
<unit name="unit" meter="{metres}"/><up_axis>Y_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="a" count="{3 * n}">{numbers}</float_array><technique_common>
<accessor source="#a" count="{n}" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="{n // 3}"><input semantic="VERTEX" source="#v" offset="0"/>
<p>{" ".join(map(str, range(n)))}</p></triangles></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n"><instance_geometry url="#g"/></node></visual_scene>
</library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>""".encode()


@pytest.mark.parametrize(
    ("name", "content", "scale"),
    [
        ("binary.stl", stl(ELBOW), 1.0),
        ("ascii.STL", ascii_stl(ELBOW), 1.0),
        ("mm.stl", stl(1000.0 * ELBOW), 0.001),
        ("elbow.obj", obj(ELBOW), 1.0),
        ("elbow.dae", collada(ELBOW, 1.0), 1.0),
        ("elbow_in_cm.dae", collada(100.0 * ELBOW, 0.01), 1.0),
    ],
)
def test_every_format_gives_the_same_triangles(name: str, content: bytes, scale: float) -> None:
    triangles = parse_triangles(Path(name), content, (scale,) * 3)
    np.testing.assert_allclose(
        np.unique(triangles.reshape(-1, 3).round(6), axis=0),
        np.unique(ELBOW.reshape(-1, 3).round(6), axis=0),
        atol=2e-6,
    )


@pytest.mark.parametrize(
    ("name", "content", "problem"),
    [
        ("a.stl", b"solid nothing\nendsolid\n", "no triangles|can be read"),
        ("a.stl", b"\x00" * 100, "can be read|no triangles"),
        ("a.dae", b"<COLLADA", "is no DAE mesh that can be read"),
        ("a.obj", b"v 0 0 0\n", "no triangles|can be read"),
        ("a.stl", stl(1000.0 * ELBOW), "a mesh in mm needs scale"),
        ("a.stl", stl(ELBOW * [1.0, 1.0, 0.0]), "is flat"),
        ("a.step", b"ISO-10303", r"expected a mesh in \.stl, \.obj, \.dae"),
    ],
)
def test_what_is_no_mesh_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, content: bytes, problem: str
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    (tmp_path / name).write_bytes(content)
    with pytest.raises(InputError, match=problem):
        mesh_pieces(tmp_path / name, (1.0, 1.0, 1.0))


def test_a_cache_that_cannot_be_written_is_told_of_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    (tmp_path / "cache").write_text("no folder")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    for name in ("a.stl", "b.stl"):
        (tmp_path / name).write_bytes(stl(ELBOW))
        assert mesh_pieces(tmp_path / name, (1.0, 1.0, 1.0))
    (told,) = [record.getMessage() for record in caplog.records if record.levelname == "WARNING"]
    assert str(tmp_path / "cache") in told and "XDG_CACHE_HOME" in told


def test_pieces_are_found_again_unless_the_mesh_or_the_cache_changed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    mesh = tmp_path / "elbow.stl"
    mesh.write_bytes(stl(ELBOW))
    first = mesh_pieces(mesh, (1.0, 1.0, 1.0))
    (kept,) = (tmp_path / "cache").rglob("*.json")
    again = mesh_pieces(mesh, (1.0, 1.0, 1.0))
    assert [piece.tolist() for piece in again] == [piece.tolist() for piece in first]
    kept.write_bytes(kept.read_bytes().replace(b"0.1", b"0.2"))  # as nobody wrote it
    assert [piece.tolist() for piece in mesh_pieces(mesh, (1.0, 1.0, 1.0))] == [p.tolist() for p in first]
    assert mesh_pieces(mesh, (2.0, 1.0, 1.0))[0][:, 0].max() == pytest.approx(2 * first[0][:, 0].max())
