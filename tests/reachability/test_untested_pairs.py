"""Disabled pairs of links that collide: found by samples, against rectangles in a plane as oracle."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell, load_workcell
from pickcli.collision.robot_model import CollisionModel
from pickcli.geometry import Array
from pickcli.kinematics.arm import Arm
from pickcli.precompute.empty_cell_checkers import checker
from pickcli.reachability.untested_pairs import (
    ALWAYS,
    N_SAMPLES,
    overlap_note,
    untested_pairs,
    untested_pairs_of_arms,
)
from pickcli.roadmap.trajectory_database import PayloadClass
from pickcli.robot_setup.cell_setup import set_up_cell
from pickcli.robot_setup.setup_options import SetupOptions, StatedLimit
from pickcli.seeds import derived_rng
from support.command_line import apc
from support.two_arms import write_two_arms

# Three bars of 0.2 m x 0.04 m in a plane, each 0.05 m beyond a joint about z: the last folds onto the first.
BAR = """<link name="{name}"><collision><origin xyz="0.15 0 0"/><geometry>{shape}</geometry></collision></link>
<joint name="to_{name}" type="revolute"><parent link="{parent}"/><child link="{name}"/><origin xyz="{at} 0 0"/><axis xyz="0 0 1"/><limit lower="-{range}" upper="{range}" effort="9" velocity="1"/></joint>
"""  # noqa: E501
BOX = '<box size="0.2 0.04 0.3"/>'
SHIELD = """<link name="shield"><collision><origin xyz="0.15 0 0"/><geometry><box size="0.22 0.06 0.3"/></geometry></collision></link>
<joint name="shielded" type="fixed"><parent link="c"/><child link="shield"/></joint>
"""  # noqa: E501
FIGURES = tuple(StatedLimit(kind, None, 5.0) for kind in ("acceleration", "jerk"))
OPEN, STIFF = 3.0, 0.05  # rad by which a joint turns to either side

# As a mesh, a bar so long that with stiff joints the bar after next lies in it in every configuration:
# two halves with a slot of 8 mm between them, too thin to be worth a cut into convex pieces.
SLOT, THIN = '<mesh filename="slot.obj"/>', '<box size="0.2 0.04 0.004"/>'
LONG = '<box size="1.6 0.2 0.3"/>'


def slotted() -> str:
    """OBJ of the two halves."""
    lines = []
    for half, (low, high) in enumerate(((-0.15, -0.004), (0.004, 0.15))):
        lines += [
            f"v {x} {y} {z}"
            for z in (low, high)
            for x, y in ((-0.8, -0.1), (0.8, -0.1), (0.8, 0.1), (-0.8, 0.1))
        ]
        for face in ("132", "143", "567", "578", "126", "165", "348", "387", "158", "184", "237", "276"):
            lines.append("f " + " ".join(str(int(corner) + 8 * half) for corner in face))
    return "\n".join(lines) + "\n"


def cell_of_bars(
    folder: Path,
    disabled: dict[str, str],
    more: str = "",
    turn: float = OPEN,
    bars: tuple[str, str] = (BOX, BOX),
) -> Cell:
    """A cell of three bars; ``disabled`` has the reason by the names of two links, as in an SRDF."""
    links = [
        BAR.format(name="a", parent="base", at=0, range=0.5, shape=bars[0]),
        BAR.format(name="b", parent="a", at=0.3, range=turn, shape=BOX),
        BAR.format(name="c", parent="b", at=0.3, range=turn, shape=bars[1]),
    ]
    urdf, srdf = folder / "bars.urdf", folder / "bars.srdf"
    urdf.write_text(f'<robot name="bars">\n<link name="base"/>\n{"".join(links)}{more}</robot>\n')
    lines = [
        '<disable_collisions link1="{}" link2="{}" reason="{}"/>'.format(*names.split(), reason)
        for names, reason in disabled.items()
    ]
    srdf.write_text("\n".join(['<robot name="bars">', *lines, "</robot>"]))
    set_up_cell(folder / "cell", SetupOptions(urdf, srdf=srdf, figures=FIGURES))
    return load_cell(folder / "cell")


def corners(origin: Array, angle: Array) -> Array:
    """Corners (N, 4, 2) of bars at their joints (N, 2), turned by angles (N,)."""
    along = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    across = np.stack([-along[:, 1], along[:, 0]], axis=-1)
    ends = [(0.05, -0.02), (0.25, -0.02), (0.25, 0.02), (0.05, 0.02)]
    return np.stack([origin + x * along + y * across for x, y in ends], axis=1)


def overlaps(Q: Array) -> Array:
    """Depths (N,) of the overlap of the first bar and the last, negative if apart: separating axes."""
    zero = np.zeros((len(Q), 2))
    turned = np.cumsum(Q, axis=1)
    at_b = 0.3 * np.stack([np.cos(turned[:, 0]), np.sin(turned[:, 0])], axis=-1)
    at_c = at_b + 0.3 * np.stack([np.cos(turned[:, 1]), np.sin(turned[:, 1])], axis=-1)
    first, last = corners(zero, turned[:, 0]), corners(at_c, turned[:, 2])
    depths = []
    for angle in (turned[:, 0], turned[:, 0] + np.pi / 2, turned[:, 2], turned[:, 2] + np.pi / 2):
        way = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        on_a, on_c = (np.einsum("nkd,nd->nk", bar, way) for bar in (first, last))
        depths.append(np.minimum(on_a.max(1) - on_c.min(1), on_c.max(1) - on_a.min(1)))
    return np.asarray(np.min(depths, axis=0))


def is_free(cell: Cell, q: Array) -> bool:
    model = CollisionModel(cell)
    return checker(model, cell.robot.tool.default_state, PayloadClass.EMPTY).is_valid(q)


def test_a_disabled_pair_that_sometimes_collides_is_found_where_planning_sees_nothing(tmp_path: Path) -> None:
    cell = cell_of_bars(tmp_path, {"a c": "Never"})
    (found,) = untested_pairs(cell)
    Q = np.random.default_rng(7).uniform(-1.0, 1.0, (40_000, 3)) * [0.5, OPEN, OPEN]
    assert found.share == pytest.approx((overlaps(Q) > 0.0).mean(), rel=0.3)
    assert found.depth == pytest.approx(overlaps(found.arm.q[None])[0], abs=1e-4)
    assert found.depth > 0.9 * 0.04  # as deep as the bars are wide, nearly
    assert is_free(cell, found.arm.q) and not is_free(replace(cell, allowed_pairs=()), found.arm.q)


def test_a_disabled_pair_that_never_collides_is_not_found(tmp_path: Path) -> None:
    assert untested_pairs(cell_of_bars(tmp_path, {"a c": "Never"}, turn=1.0)) == []


def test_neighbours_are_not_found(tmp_path: Path) -> None:
    cell = cell_of_bars(tmp_path, {"a b": "Adjacent", "b c": "Adjacent"})
    assert len(cell.allowed_pairs) == 2 and untested_pairs(cell) == []


def test_a_collision_that_another_test_reports_is_not_found(tmp_path: Path) -> None:
    """The last bar lies in a shield: where it meets the first one, so does the shield, which is tested."""
    disabled = {"a c": "User", "b shield": "Adjacent"}
    one = untested_pairs(cell_of_bars(tmp_path, disabled, SHIELD))
    assert [each.names for each in one] == [{"b", "shield"}]
    (tmp_path / "both").mkdir()
    both = untested_pairs(cell_of_bars(tmp_path / "both", disabled | {"a shield": "User"}, SHIELD))
    assert [each.names for each in both] == [{"a", "c"}, {"b", "shield"}, {"a", "shield"}]


def test_a_pair_that_the_verifier_tests_is_not_found(tmp_path: Path) -> None:
    cell = cell_of_bars(tmp_path, {"a c": "Never"})
    tested = replace(cell, allowed_pairs=tuple(replace(pair, verified=True) for pair in cell.allowed_pairs))
    assert untested_pairs(tested) == []


def test_a_collision_too_rare_for_the_sample_is_found_by_a_search(tmp_path: Path) -> None:
    """Only where both joints are within a degree or two of their limits do the bars meet."""
    cell = cell_of_bars(tmp_path, {"a c": "Never"}, turn=2.14)
    Q = Arm(cell.robot).random_seeds(derived_rng(0, "collisions of links"), N_SAMPLES)
    assert (overlaps(Q) < 0.0).all()
    (found,) = untested_pairs(cell)
    assert found.depth == pytest.approx(overlaps(found.arm.q[None])[0], abs=1e-4)
    assert found.share == pytest.approx(1.0 / N_SAMPLES, rel=0.01) and found.is_sometimes
    assert "collide in 1 of 1000" in found.text
    assert is_free(cell, found.arm.q) and not is_free(replace(cell, allowed_pairs=()), found.arm.q)


@pytest.mark.parametrize(
    ("bars", "is_hidden"), [((LONG, BOX), False), ((SLOT, BOX), False), ((SLOT, THIN), True)]
)
def test_a_note_names_links_of_which_only_convex_pieces_overlap(
    tmp_path: Path, bars: tuple[str, str], is_hidden: bool
) -> None:
    (tmp_path / "slot.obj").write_text(slotted())
    cell = cell_of_bars(tmp_path, {"a c": "Always"}, turn=STIFF, bars=bars)
    (found,) = untested_pairs(cell)
    assert found.pieces == 1.0 and found.share == (0.0 if is_hidden else 1.0)
    assert (found.is_sometimes, found.is_hidden) == (False, is_hidden)
    note = overlap_note([found])
    assert (note is not None and note.startswith("nothing tests a and c: ")) == is_hidden
    told = apc("check", cell.path)
    assert ("note: nothing tests a and c: " in told.out) == is_hidden and "colliding" not in told.err


def test_meshes_collide_where_their_triangles_do(tmp_path: Path) -> None:
    """Convex pieces overlap wherever the thin bar is over the slotted one, the meshes nowhere."""
    (tmp_path / "slot.obj").write_text(slotted())
    cell = cell_of_bars(tmp_path, {"a c": "Never"}, bars=(SLOT, THIN))
    found = untested_pairs(cell)
    assert [(each.share, 0.0 < each.pieces < ALWAYS, each.is_hidden) for each in found] == [
        (0.0, True, False)
    ]
    assert "colliding" not in apc("check", cell.path).err


def test_check_names_the_line_of_the_srdf_until_it_is_accepted(tmp_path: Path) -> None:
    cell = cell_of_bars(tmp_path, {"a b": "Adjacent", "c a": "Default"})
    told = apc("check", cell.path)
    assert f"{cell.path}/robot.srdf:3:1: disable_collisions: c and a are not tested against" in told.err
    assert "overlap in the default pose" in told.err and " mm deep, e.g. at " in told.err
    assert "add colliding_pair:c-a to accepted_warnings of cell.yaml" in told.err
    assert apc("check", cell.path, "--strict").code == 3
    text = (cell.path / "cell.yaml").read_text()
    (cell.path / "cell.yaml").write_text(f'{text}accepted_warnings: ["colliding_pair:c-a"]\n')
    accepted = apc("check", cell.path)
    assert "colliding" not in accepted.err and accepted.code == 0


def test_init_notes_what_it_disables(tmp_path: Path) -> None:
    cell_of_bars(tmp_path, {"a c": "User"})
    words = ("--max-acceleration", "5", "--max-jerk", "50", "--srdf", tmp_path / "bars.srdf")
    told = apc("init", tmp_path / "again", "--urdf", tmp_path / "bars.urdf", *words)
    assert "note: robot.srdf:2: a and c are not tested against each other (User), but collide" in told.out


def test_a_pair_between_two_arms_is_found_wherever_the_other_one_stands(tmp_path: Path) -> None:
    """Parked arms keep clear of each other; elsewhere the hands meet, and nothing else does before them."""
    folder = write_two_arms(tmp_path)
    disabled = [
        f"  - {{a: left_{a}, b: right_{b}, reason: disabled by hand}}\n"
        for a in ("lower", "hand")
        for b in ("lower", "hand")
    ]
    text = (folder / "cell.yaml").read_text()
    assert untested_pairs_of_arms(load_workcell(folder)) == []
    (folder / "cell.yaml").write_text(
        text.replace("allowed_pairs: []\n", f"allowed_pairs:\n{''.join(disabled)}")
    )
    found = untested_pairs_of_arms(load_workcell(folder))
    assert {"left_hand", "right_hand"} in [each.names for each in found]
    assert any(each.others for each in found)
    for each in found:
        beside = load_workcell(folder).cell(each.arm.arm, each.others)
        assert is_free(beside, each.arm.q) and not is_free(replace(beside, allowed_pairs=()), each.arm.q)


def test_a_seed_stands_for_one_answer(tmp_path: Path) -> None:
    cell = cell_of_bars(tmp_path, {"a c": "Never"})
    texts = [untested_pairs(cell, seed)[0].text for seed in (1, 1, 2)]
    assert texts[0] == texts[1] != texts[2]
    assert N_SAMPLES >= 10_000
