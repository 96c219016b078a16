"""KTH's task space regions: read safely, and kept by the seals and areas that they become."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.cell.cell_file import load_cell
from pickcli.cell.item import Item
from pickcli.cell.schemas.items_file import load_items, read_items
from pickcli.cell.schemas.items_text import items_text
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.errors import InputError
from pickcli.grasping.box_tsr import BoxTsr, orientation, read_box_tsrs
from pickcli.grasping.region_import import KTH_CUP_RADIUS, axes_by_size, import_regions
from pickcli.grasping.surfaces import faces
from support.command_line import apc, misused, refused

TOOL = load_cell("apc2016_delft").robot.tool
ITEMS = load_items()
FREE = (-3.14, 3.14)
DOVE = [  # KTH's regions of the soap: 90 x 33 x 63 mm, the faces across y
    ((-0.0275, 0.0275), (0.0165, 0.0165), (-0.014, 0.014), FREE, (-0.001, 0.001), (1.56, 1.58)),
    ((-0.0275, 0.0275), (-0.0165, -0.0165), (-0.014, 0.014), FREE, (-0.001, 0.001), (-1.58, -1.56)),
]


def text_of(regions: Sequence[tuple[tuple[float, float], ...]]) -> str:
    lines = []
    for region in regions:
        lines += ["- !BoxTSR", "  extents:", *(f"  - [{low!r}, {high!r}]" for low, high in region)]
    return "\n".join(lines) + "\n"


def regions_of(*regions: tuple[tuple[float, float], ...]) -> list[BoxTsr]:
    return [BoxTsr(np.array(region)) for region in regions]


def facing(face: str, a: float = 0.0) -> tuple[float, float, float]:
    """Angles with which a tool comes at a face, turned about its axis, as KTH's files have them."""
    return {
        "+z": (a, np.pi, 0.0), "-z": (a, 0.0, 0.0), "+x": (0.0, -np.pi / 2, a), "-x": (0.0, np.pi / 2, a),
        "+y": (a, 0.0, np.pi / 2), "-y": (a, 0.0, -np.pi / 2),
    }[face]  # fmt: skip


def box_item(size: tuple[float, ...]) -> Item:
    return replace(ITEMS["dove_beauty_bar", 2016], shape=Shape(ShapeKind.BOX, size), areas={})


def with_their_cup(item: Item) -> Item:
    """The item for a cup as wide as theirs, 2.5 mm more than that of the cell, less a hair for rounding."""
    return replace(item, seal_inset=KTH_CUP_RADIUS - TOOL.cup.radius - 1e-6)


# The files


def test_a_file_of_kth_is_read(tmp_path: Path) -> None:
    path = tmp_path / "dove.tsrs"
    path.write_text(text_of(DOVE))
    front, back = read_box_tsrs(path)
    np.testing.assert_array_equal(front.bounds, np.array(DOVE[0]))
    np.testing.assert_allclose(front.approach, [0.0, -1.0, 0.0], atol=1e-3)
    np.testing.assert_allclose(back.approach, [0.0, 1.0, 0.0], atol=1e-3)


@pytest.mark.parametrize("face", ["+x", "-x", "+y", "-y", "+z", "-z"])
@pytest.mark.parametrize("a", [-2.0, 0.0, 0.7])
def test_the_free_angle_of_each_of_their_faces_turns_the_tool_about_its_own_axis(face: str, a: float) -> None:
    inwards = np.eye(3)["xyz".index(face[1])] * (-1.0 if face[0] == "+" else 1.0)
    np.testing.assert_allclose(orientation(*facing(face, a))[:, 2], inwards, atol=1e-9)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("- !!python/object/apply:os.system [\"touch HERE\"]\n", ":1:3: tag tag:yaml.org,2002:python/object"),
        ("- !BoxTsr\n  extents: []\n", "tag !BoxTsr is not allowed"),
        ("- &a !BoxTSR\n  extents: []\n- *a\n", "anchors and aliases are not allowed"),
        ("- !BoxTSR\n  extents: []\n", "[0].extents: expected six pairs"),
        ("- !BoxTSR\n  other: 1\n", "[0]: expected extents and nothing else"),
        ("!BoxTSR\nextents: []\n", "expected a list of !BoxTSR"),
        ("[]\n", "expected a list of !BoxTSR"),
        ("", "is empty"),
        ("- " + "[" * 40, "nested deeper than"),
        (text_of([*DOVE[:1], ((0.1, 0.0), *DOVE[0][1:])]), "[1].extents[0]: expected -2 <= least <="),
        (text_of([((0.0, 3.0), *DOVE[0][1:])]), "[0].extents[0]: expected -2 <= least"),
        (text_of([(*DOVE[0][:5], (0.0, 7.0))]), "[0].extents[5]: expected -6.283"),
        (text_of(DOVE[:1]).replace("0.0165", "true"), "[0].extents[1]: expected two numbers"),
        (text_of(DOVE[:1]).replace("0.0165", ".inf"), "a finite number"),
        (text_of(DOVE[:1]).replace("0.0165", "1e999"), "too large"),
    ],
)  # fmt: skip
def test_hostile_files_are_refused_and_do_nothing(text: str, told: str, tmp_path: Path) -> None:
    path, mark = tmp_path / "bad.tsrs", tmp_path / "HERE"
    path.write_text(text.replace("HERE", str(mark)))
    with pytest.raises(InputError) as caught:
        read_box_tsrs(path)
    assert told in str(caught.value)
    assert not mark.exists()


def test_files_are_bounded(tmp_path: Path) -> None:
    many, large = tmp_path / "many.tsrs", tmp_path / "large.tsrs"
    many.write_text("- {}\n" * 10_001)
    with pytest.raises(InputError, match="10001 regions; at most 10000 are read"):
        read_box_tsrs(many)
    large.write_text("#" * 1_000_001)
    with pytest.raises(InputError, match="large"):
        read_box_tsrs(large)


# What becomes of regions


def test_regions_of_the_soap_come_back_as_its_faces() -> None:
    """With KTH's cup, 2.5 mm wider than ours, the regions of the faces are theirs again."""
    found = import_regions(regions_of(*DOVE), ITEMS["dove_beauty_bar", 2016])
    assert found.counts == {"-z": 1, "+z": 1} and found.left_out == ()
    by_name = {face.name: face.region for face in faces(with_their_cup(found.item), TOOL)}
    assert set(by_name) == {"+z", "-z"}
    for region in by_name.values():
        half = np.sort(np.abs(region.T_object_region[:3, :3] @ region.bounds[:3, 1]))
        np.testing.assert_allclose(half, [0.0, 0.014, 0.0275], atol=1e-3)


RECTANGLE = st.tuples(
    *(st.floats(-0.02, 0.02), st.floats(0.0, 0.02), st.floats(-0.01, 0.01), st.floats(0.0, 0.01))
)


@given(st.sampled_from(["+x", "-x", "+y", "-y", "+z", "-z"]), RECTANGLE)
@settings(max_examples=80, deadline=None)
def test_every_tool_pose_of_a_region_is_one_of_the_face_and_no_other(
    face: str, rectangle: tuple[float, ...]
) -> None:
    item = box_item((0.2, 0.16, 0.12))
    k = "xyz".index(face[1])
    at = (1.0 if face[0] == "+" else -1.0) * item.shape.extents[k] / 2
    u, du, v, dv = rectangle
    sides = iter(((u - du, u + du), (v - dv, v + dv)))
    extents = tuple((at, at) if i == k else next(sides) for i in range(3))
    theirs = BoxTsr(np.array([*extents, *((angle, angle) for angle in facing(face))]))
    found = import_regions([theirs], item, axes=np.eye(3))
    (ours,) = faces(with_their_cup(found.item), TOOL)
    assert ours.name == face
    low, high = theirs.corners
    bounds = ours.region.bounds
    ends = np.array([[x, y, 0.0, 0.0, 0.0, 0.0] for x in bounds[0] for y in bounds[1]])
    positions = ours.region.poses_at(ends)[:, :3, 3]
    np.testing.assert_allclose([positions.min(axis=0), positions.max(axis=0)], [low, high], atol=2e-4)


def test_samples_around_a_cylinder_become_its_mantle() -> None:
    """As KTH samples a bottle: its axis along y, the cup around it at several heights."""
    bottle = ITEMS["dasani_water_bottle", 2016]
    around = []
    for angle in np.linspace(-np.pi, np.pi, 12, endpoint=False):
        for y in (-0.0425, 0.0, 0.0425):
            x, z = 0.028 * np.sin(angle), 0.028 * np.cos(angle)
            turn = (0.0, angle + np.pi, 0.0)
            around.append(BoxTsr(np.array([[v, v] for v in (x, y, z, *turn)])))
    for region in around:
        outward = region.corners[0] * (1.0, 0.0, 1.0)
        np.testing.assert_allclose(region.approach, -outward / np.linalg.norm(outward), atol=1e-9)
    found = import_regions(around, bottle)
    assert found.counts == {"mantle": 36}
    assert found.item.areas == {"mantle": {"z": (-0.06, 0.06)}}
    assert found.item.seals == {"+z": 0.0, "-z": 0.0, "mantle": bottle.seals["mantle"]}


def test_axes_are_a_rotation_found_by_sizes() -> None:
    S = axes_by_size(regions_of(*DOVE), ITEMS["dove_beauty_bar", 2016])
    np.testing.assert_array_equal(np.abs(S), [[1, 0, 0], [0, 0, 1], [0, 1, 0]])
    assert np.linalg.det(S) == pytest.approx(1.0)


def test_what_does_not_lie_on_the_item_is_left_out_and_told() -> None:
    item = box_item((0.09, 0.06, 0.03))
    off = ((0.03, 0.05), (0.0, 0.0), (0.015, 0.015), FREE, (3.14, 3.15), (0.0, 0.0))
    tilted = ((0.0, 0.0), (0.0, 0.0), (0.015, 0.015), FREE, (2.4, 2.4), (0.0, 0.0))
    good = ((-0.01, 0.01), (0.0, 0.0), (0.015, 0.015), FREE, (3.14, 3.15), (0.0, 0.0))
    above = ((-0.01, 0.01), (0.0, 0.0), (0.2, 0.2), FREE, (3.14, 3.15), (0.0, 0.0))
    below = ((-0.01, 0.01), (0.0, 0.0), (-0.2, -0.2), FREE, (3.14, 3.15), (0.0, 0.0))
    found = import_regions(regions_of(off, tilted, good, above, below), item, axes=np.eye(3))
    assert found.counts == {"+z": 1} and len(found.left_out) == 4
    assert found.left_out[2:] == ("region 3: it is 185 mm off +z", "region 4: it is 215 mm off +z")
    assert found.left_out[0].startswith("region 0: reaches beyond +z")
    assert found.left_out[1] == "region 1: the tool comes 42 degrees off every face"
    with pytest.raises(InputError, match=r"none of 2 regions lies on dove_beauty_bar .*state --axes"):
        import_regions(regions_of(off, tilted), item, axes=np.eye(3))


def test_an_item_that_nothing_holds_needs_a_seal() -> None:
    cup = ITEMS["rolodex_jumbo_pencil_cup", 2015]
    above = [((0.0, 0.0), (0.0, 0.0), (0.05, 0.05), FREE, (3.14, 3.15), (0.0, 0.0))]
    with pytest.raises(InputError, match="state --seal"):
        import_regions(regions_of(*above), cup, axes=np.eye(3))
    found = import_regions(regions_of(*above), cup, axes=np.eye(3), seal=0.5)
    assert max(found.item.seals.values()) == 0.5 and found.item.why_not == ""


def test_hollows_are_left_out_as_regions_know_the_outer_shape(tmp_path: Path) -> None:
    """A face that seals all over, by a region, and that a hollow opens through could not be read again."""
    brush = ITEMS["dr_browns_bottle_brush", 2016]
    front = [((-0.01, 0.01), (0.0, 0.0), (0.029, 0.029), FREE, (3.14, 3.15), (0.0, 0.0))]
    found = import_regions(regions_of(*front), brush, axes=np.eye(3)).item
    assert brush.hollows and not found.hollows
    assert found.seals["+z"] > 0.0 and set(found.seals) == set(brush.shape.face_names)
    path = tmp_path / "item.yaml"
    path.write_text(items_text([found]))
    assert list(read_items(path).values()) == [found]


# Files of items


@pytest.mark.parametrize("item", ITEMS.values(), ids=lambda item: f"{item.name}-{item.year}")
def test_an_item_is_read_as_it_was_written(item: Item, tmp_path: Path) -> None:
    path = tmp_path / "item.yaml"
    path.write_text(items_text([item], "one item\nof many"))
    (back,) = read_items(path).values()
    assert back == item
    assert (back.seals, back.areas) == (item.seals, item.areas)


# The commands


@pytest.fixture
def dove(tmp_path: Path) -> Path:
    path = tmp_path / "dove.tsrs"
    path.write_text(text_of(DOVE))
    return path


def test_what_is_imported_can_be_picked_and_shown(dove: Path, tmp_path: Path) -> None:
    out, page = tmp_path / "dove.yaml", tmp_path / "dove.html"
    answer = apc("import-tsr", dove, "--item", "dove_beauty_bar", "-o", out)
    assert answer.code == 0, answer.err
    assert answer.out.splitlines()[0] == "dove_beauty_bar_tsr: 2 of 2 regions on -z, +z; axes x,z,-y"
    assert read_items(out)["dove_beauty_bar_tsr", 2016].seal_source.endswith("regions of dove.tsrs")
    told = json.loads(apc("show-grasps", "dove_beauty_bar_tsr", "--items", out, "-o", page, "--json").out)
    assert {grasp["face"] for grasp in told["grasps"]} <= {"+z", "-z"} and told["grasps"]
    assert page.stat().st_size == told["bytes"]
    first = page.read_bytes()
    assert apc("show-grasps", "dove_beauty_bar_tsr", "--items", out, "-o", page, "--overwrite").code == 0
    assert page.read_bytes() == first, "the same again"


def test_axes_that_are_stated_count(dove: Path, tmp_path: Path) -> None:
    told = json.loads(
        apc("import-tsr", dove, "--item", "dove_beauty_bar", "--axes", "-x,z,y", "-o", tmp_path / "d.yaml",
            "--json").out
    )  # fmt: skip
    assert (told["axes"] == "-x,z,y" and told["faces"] == {"-z": 1, "+z": 1}) or told["faces"] == {
        "+z": 1,
        "-z": 1,
    }


@pytest.mark.parametrize("axes", ["x,y", "x,x,y", "x,z,y", "a,b,c", "", "x,y,z,x"])
def test_axes_of_a_mirror_or_of_none_are_wrong_usage(axes: str, dove: Path, tmp_path: Path) -> None:
    out = tmp_path / "d.yaml"
    misused(apc("import-tsr", dove, "--item", "dove_beauty_bar", f"--axes={axes}", "-o", out), "--axes")
    assert not out.exists()


@pytest.mark.parametrize("option", ["--rim", "--seal"])
@pytest.mark.parametrize("value", ["nan", "inf", "-1", "x"])
def test_figures_out_of_range_are_wrong_usage(option: str, value: str, dove: Path, tmp_path: Path) -> None:
    out = tmp_path / "d.yaml"
    misused(apc("import-tsr", dove, "--item", "dove_beauty_bar", f"{option}={value}", "-o", out), option)
    assert not out.exists()


def test_names_that_cannot_be_are_refused(dove: Path, tmp_path: Path) -> None:
    out = tmp_path / "d.yaml"
    line = ("import-tsr", dove, "-o", out, "--item")
    refused(apc(*line, "dove_beauty_bra"), 3, "did you mean 'dove_beauty_bar'?")
    refused(
        apc(*line, "dove_beauty_bar", "--as", "crayola_24_ct"), 3, "there is an item crayola_24_ct already"
    )
    refused(apc(*line, "dove_beauty_bar", "--as", "My Soap"), 3, "is not a name of an item")
    refused(apc(*line, "dove_beauty_bar", "--year", 2099), 3, "not of 2099")
    refused(apc("show-grasps", "soap", "-o", tmp_path / "p.html"), 3, "unknown item 'soap'")
    refused(apc("show-grasps", "dove_beauty_bar", "-o", tmp_path / "p.png"), 3, "a page is written as .html")
    place = ("--place", "bin_Z", "-o", tmp_path / "p.html")
    refused(apc("show-grasps", "dove_beauty_bar", *place), 3, "--place: unknown place 'bin_Z'")
    assert not out.exists() and not (tmp_path / "p.html").exists()


def test_an_item_without_grasps_is_shown_with_the_reason(tmp_path: Path) -> None:
    told = json.loads(
        apc("show-grasps", "fitness_gear_3lb_dumbbell", "-o", tmp_path / "page.html", "--json").out
    )
    assert told["grasps"] == [] and "cannot be held by suction" in told["dropped"][0]
