"""Pairs of links that always, sometimes and never collide, told apart by samples."""

from __future__ import annotations

from pathlib import Path

import pytest

from pickcli.cell.cell_file import load_cell
from pickcli.robot_setup.cell_setup import CellSetup, set_up_cell
from pickcli.robot_setup.collision_sampling import N_SHAPES, CollisionCount, CollisionFrequency
from pickcli.robot_setup.setup_options import SetupOptions, StatedLimit

ALWAYS, SOMETIMES, NEVER = CollisionFrequency

# Four links in a row that turn about z, "a" and "c" on one level, "b" and "d" on another: "c" lies over "a"
# as far as it turns, "d" folds onto "b" where it is turned far, "a" and "d" pass each other.
ROW = """<robot name="row">
<link name="base"/>
{links}
</robot>
"""
LINK = """<link name="{name}"><collision><origin xyz="{x} 0 {z}"/><geometry><box size="{long} 0.04 0.02"/></geometry></collision></link>
<joint name="to_{name}" type="revolute"><parent link="{parent}"/><child link="{name}"/><origin xyz="{at} 0 {up}"/><axis xyz="0 0 1"/><limit lower="-{range}" upper="{range}" effort="9" velocity="1"/></joint>
"""  # noqa: E501
FIGURES = tuple(StatedLimit(kind, None, 5.0) for kind in ("acceleration", "jerk"))


def row(folder: Path) -> Path:
    links = [
        LINK.format(name="a", parent="base", x=0.1, z=0, long=0.2, at=0, up=0, range=1.5),
        LINK.format(name="b", parent="a", x=0.1, z=0, long=0.2, at=0.2, up=0.1, range=0.05),
        LINK.format(name="c", parent="b", x=-0.2, z=-0.1, long=0.2, at=0, up=0, range=0.05),
        LINK.format(name="d", parent="c", x=0.1, z=0, long=0.2, at=0.3, up=0, range=3.0),
    ]
    path = folder / "row.urdf"
    path.write_text(ROW.format(links="".join(links)))
    return path


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> CellSetup:
    folder = tmp_path_factory.mktemp("row")
    return set_up_cell(folder / "cell", SetupOptions(row(folder), figures=FIGURES))


def test_pairs_are_told_apart(made: CellSetup) -> None:
    counted = {pair.a + pair.b: (pair.spheres, pair.shapes) for pair in made.collisions}
    assert counted == {
        "ac": (CollisionFrequency.ALWAYS, CollisionFrequency.ALWAYS),
        "ad": (CollisionFrequency.NEVER, None),
        "bd": (CollisionFrequency.SOMETIMES, None),
    }
    assert made.n_pairs == dict.fromkeys(CollisionFrequency, 1)


def test_only_what_always_collides_is_allowed_and_with_its_count(made: CellSetup) -> None:
    (pair,) = load_cell(made.folder).allowed_pairs
    assert {pair.a, pair.b} == {"a", "c"}
    assert pair.reason == f"within 6 mm of each other in all of {N_SHAPES} sampled configurations"
    assert not made.left and not made.notes


@pytest.mark.parametrize(
    ("spheres", "shapes", "least", "most", "allowed"),
    [
        (ALWAYS, NEVER, 0.007, 0.01, "sampled configurations, shapes in none, 7.0 mm apart at least"),
        (ALWAYS, SOMETIMES, 0.003, 0.01, "sampled configurations, shapes in some, 3.0 mm apart at least"),
        (ALWAYS, SOMETIMES, 0.001, 0.01, "sampled configurations, shapes in some, 1.0 mm apart at least"),
        (ALWAYS, SOMETIMES, 0.0, 0.01, "sampled configurations, shapes in some"),
        (ALWAYS, ALWAYS, 0.004, 0.005, "within 6 mm of each other in all of 200"),
        (ALWAYS, ALWAYS, 0.0, 0.005, "within 6 mm of each other in all of 200"),
        (ALWAYS, ALWAYS, 0.0, 0.0, "within 6 mm of each other in all of 200"),
        (SOMETIMES, None, 0.0, 0.0, None),
        (NEVER, None, 0.0, 0.0, None),
    ],
)
def test_a_pair_is_allowed_only_where_nothing_could_be_planned_otherwise(
    spheres: CollisionFrequency,
    shapes: CollisionFrequency | None,
    least: float,
    most: float,
    allowed: str | None,
) -> None:
    pair = CollisionCount(
        "a", "b", spheres, shapes, least, most, 0.006
    )  # of which the cell's clearance is 3 mm
    assert (pair.allowed is None) == (allowed is None)
    assert pair.is_doubtful == (least == 0.0 < most)  # nobody tests it where it is free
    if pair.allowed is not None:
        assert allowed is not None and allowed in pair.allowed.reason
        assert pair.allowed.verified == (least >= 0.003)
