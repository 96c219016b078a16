"""Files of hands: what is read, and every mistake in one line with its place."""

from __future__ import annotations

from pathlib import Path

import pytest

from pickcli.cell.data_path import data_path
from pickcli.errors import InputError, UnknownNameError
from pickcli.hand.hand_file import hand_file, read_hand
from support.belt_hands import HAND

APPLE = (data_path() / "hands" / "apple.yaml").read_text()
PAPER = {  # g and mm, of Krug et al., section IV
    "box_45": (146, 45), "box_50": (163, 50), "can": (361, 53), "beer": (522, 66), "coke": (358, 58),
    "bull": (272, 53),
}  # fmt: skip


def test_the_objects_weigh_and_measure_what_the_paper_says() -> None:
    for name, (grams, millimetres) in PAPER.items():
        assert HAND.objects[name].mass == pytest.approx(grams / 1000)
        assert HAND.objects[name].width == pytest.approx(millimetres / 1000)
    bottle = HAND.objects["spray_bottle"]
    assert (bottle.mass, bottle.parts[0].shape.size[0]) == (0.127, 0.026)


def test_parts_stand_on_the_floor_or_where_they_are_put() -> None:
    bottle = HAND.objects["spray_bottle"]
    assert [float(part.T_parent_shape[2, 3]) for part in bottle.parts] == [0.045, 0.1, 0.125, 0.155]
    assert bottle.height == pytest.approx(0.17)


@pytest.mark.parametrize(
    ("right", "wrong", "told"),
    [
        ("hinge_relief: 0.0005", "hinge_relief: 0.006", "a hinge_relief below the hinge_radius of 0.006 m"),
        ("distal: 0.058", "distal: 0.01", "phalanges longer than 3 hinge_radius, 0.018 m, got 0.01"),
        ("high_current: 6.0", "high_current: 1.0", "at least the low_current of 2 A, got 1"),
        ("{cylinder: [0.033, 0.168]}", "{cylinder: [0.033, 0.168], z: 0.2}", "stands on z = 0, got 0.116 m"),
        ("{cylinder: [0.033, 0.168]}", "{cylinder: [0.033, 0.1], box: [1, 1, 1]}", "a box or a cylinder"),
        ("mass: 0.522", "mass: -0.5", "mass"),
        ("stiff: 2000.0", "stiffness: 2000.0", "stiff"),
        ("friction: 0.75", "friction: .nan", "friction"),
        ("version: 1", "version: 2", "version"),
    ],
)
def test_a_mistake_is_told_with_its_line(right: str, wrong: str, told: str, tmp_path: Path) -> None:
    assert right in APPLE
    path = tmp_path / "mine.yaml"
    path.write_text(APPLE.replace(right, wrong, 1))
    with pytest.raises(InputError) as caught:
        read_hand(path)
    assert told in str(caught.value)
    assert str(path) in str(caught.value)


def test_a_name_is_that_of_a_packaged_hand_and_else_a_path() -> None:
    assert hand_file("apple") == data_path() / "hands" / "apple.yaml"
    assert hand_file("pear.yaml") == Path("pear.yaml") and hand_file("a/pear") == Path("a/pear")
    with pytest.raises(UnknownNameError, match="unknown hand 'pear'; known: apple"):
        hand_file("pear")
