"""A parallel gripper as a cell states it: widths, fingers, what of it is refused, what its pads bear."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from pickcli.cell.cell import Cell
from pickcli.cell.tool import MOVING, ToolState
from pickcli.cell.tools.pinch_limits import PinchLimits, mean_distance
from support.cell_copies import CellCopy
from support.gripper_cell import CLOSED, FORCE, FRICTION, HALF, OPEN, PAD, WIDEST, gripper_urdf, with_gripper
from support.tool_frame import tip_in_flange

Refused = Callable[[Callable[[], object]], str]


def test_states_are_widths(cell_copy: CellCopy) -> None:
    tool = with_gripper(cell_copy).load().robot.tool
    assert tool.states == (OPEN, HALF, CLOSED) and tool.default_state == OPEN
    assert [tool.position(state) for state in tool.states] == [0.08, 0.04, 0.0]
    assert tool.position(ToolState.of_width(0.0453)) == 0.0453
    assert tool.position(MOVING) == WIDEST
    assert tool.gripper is not None and tool.suction_cup is None
    for joint in ("left_slide", "right_slide"):
        assert tool.joint_position(joint, OPEN) == 0.04
        assert tool.joint_range(joint) == (0.0, 0.04)


@pytest.mark.parametrize(
    ("name", "is_known"),
    [
        ("open", True),
        ("w_0.0453", True),
        ("w_0.0801", False),
        ("w_1", False),
        ("ajar", False),
        ("moving", False),
    ],
)
def test_a_gripper_rests_in_its_states_and_at_widths_between_them(
    cell_copy: CellCopy, name: str, is_known: bool
) -> None:
    assert with_gripper(cell_copy).load().robot.tool.knows(ToolState(name)) is is_known


def test_a_cup_rests_in_no_width(cell: Cell) -> None:
    assert not cell.robot.tool.knows(ToolState.of_width(0.0))


def test_the_tool_frame_stays_where_it_is_as_the_fingers_close(cell_copy: CellCopy, cell: Cell) -> None:
    gripper = with_gripper(cell_copy).load()
    for state in (*gripper.robot.tool.states, MOVING, ToolState.of_width(0.0123)):
        assert_allclose(tip_in_flange(gripper, state), tip_in_flange(cell, ToolState("straight")), atol=1e-12)


def test_fingers_that_open_against_their_joints_are_known(cell_copy: CellCopy) -> None:
    copy = with_gripper(cell_copy)
    gripper_urdf(copy).replace(
        '<axis xyz="0 -1 0"/>\n  <limit lower="0" upper="0.04"',
        '<axis xyz="0 1 0"/>\n  <limit lower="-0.04" upper="0"',
    )
    gripper_urdf(copy).replace('<mimic joint="left_slide"/>', '<mimic joint="left_slide" multiplier="-1"/>')
    tool = copy.load().robot.tool
    assert tool.joint_position("left_slide", HALF) == 0.02
    assert tool.joint_position("right_slide", HALF) == -0.02


def test_fingers_without_a_mimic_are_driven_as_mirrors(cell_copy: CellCopy) -> None:
    copy = with_gripper(cell_copy)
    gripper_urdf(copy).replace('  <mimic joint="left_slide"/>\n', "")
    assert copy.load().robot.tool.joints == ("left_slide", "right_slide")


# A tip of the left finger, as a shape of it and as a link of its own behind another one.
ENDS = '<origin xyz="0.0 0.01 0.09"/><geometry><box size="0.01 0.01 0.02"/></geometry></collision>\n'
AS_SHAPE = f'<link name="left_finger"><collision name="left_tip">{ENDS}'
AS_LINK = f"""<link name="left_mount"/>
<joint name="left_mounted" type="{{kind}}"><parent link="left_finger"/><child link="left_mount"/>
<origin xyz="0 0 0.05"/><axis xyz="0 0 1"/><limit lower="-1" upper="1"/></joint>
<link name="left_tip"><collision name="left_tip">{ENDS.replace("0.09", "0.04")}</link>
<joint name="left_tipped" type="fixed"><parent link="left_mount"/><child link="left_tip"/></joint>
<link name="left_finger">"""


def test_what_is_fixed_to_a_finger_is_a_part_of_it(cell_copy: CellCopy) -> None:
    copy = with_gripper(cell_copy)
    before, urdf = copy.load().fingerprint, gripper_urdf(copy).path
    plain = urdf.read_text()
    prints = set()
    for text in (AS_SHAPE, AS_LINK.format(kind="fixed")):
        urdf.write_text(plain.replace('<link name="left_finger">', text))
        prints.add(copy.load().fingerprint)
    assert len(prints) == 1 and before not in prints


URDF, YAML = "gripper.urdf", "cell.yaml"
MISTAKES = {
    "no kind": (YAML, "  kind: gripper\n", "",
                "tool.kind: expected gripper: these are the keys of one, got nothing; add it"),
    "another kind": (YAML, "  kind: gripper\n", "  kind: grippre\n",
                     "tool.kind: expected suction or gripper, got 'grippre'; correct it"),
    "friction 0": (YAML, "friction: 0.5", "friction: 0", "tool.friction: expected friction between pads"),
    "no force": (YAML, "  force: 40.0\n", "", "tool.force: expected N with which each pad presses"),
    "no such finger": (YAML, "[left_finger,", "[left_fingr,", "tool.fingers[0]: no link is named 'left_fing"),
    "one finger": (YAML, "[left_finger, right_finger]", "[left_finger, left_finger]",
                   "tool.fingers: expected two links, got one twice"),
    "a finger that turns": (URDF, '"left_slide" type="prismatic"', '"left_slide" type="revolute"',
                            "tool.fingers[0]: expected 'left_finger' to slide in 'hand' on a prismatic "
                            "joint, got a revolute joint"),
    "an axis across": (YAML, "rpy: [0, 0, 0]}\n  fingers", "rpy: [0, 0, 1.5707963]}\n  fingers",
                       "tool.fingers[0]: 'left_finger' moves across the y axis of T_hand_tip; turn that"),
    "fingers that follow each other": (URDF, '<mimic joint="left_slide"/>',
                                       '<mimic joint="left_slide" multiplier="-1"/>',
                                       "tool.fingers: joint 'right_slide' mimics 'left_slide' by -1 and 0 m"),
    "a finger that goes farther": (URDF, '<mimic joint="left_slide"/>',
                                   '<mimic joint="left_slide" multiplier="0.5"/>', "mirror each other"),
    "too wide": (YAML, "open: 0.08", "open: 0.09",
                 "tool.states.open: expected 0 to 0.08 m, as far as the joints of the fingers go, got 0.09"),
    "two of one width": (YAML, "half: 0.04", "half: 0.08", "tool.states: two are the same width"),
    "shut at first": (YAML, "{open: 0.08, half: 0.04, closed: 0.0}", "{closed: 0.0, half: 0.04, open: 0.08}",
                      "tool.states: the first is the default, and closed is the narrowest, so that the hand "
                      "would come to an item with its fingers shut; put an open one first, e.g. open"),
    "one state": (YAML, "{open: 0.08, half: 0.04, closed: 0.0}", "{open: 0.08}",
                  "usual one first: at least 2 entries, got 1"),
    "a stroke in mm that opens nothing": (YAML, "open: 0.08, half: 0.04", "open: 0.0008, half: 0.0004",
                                          "nothing fits between the pads: widths are in m, not mm"),
    "pads wider than the fingers": (YAML, "pad_size: [0.02,", "pad_size: [0.03,",
                                    "tool.pad_size: a pad of 0.03 x 0.02 m is not all on 'left_finger'"),
    "pads below the fingers": (YAML, "xyz: [0, 0, 0.54], rpy: [0, 0, 0]}\n  fingers",
                               "xyz: [0, 0, 0.58], rpy: [0, 0, 0]}\n  fingers",
                               "is not all on 'right_finger'"),
    "a gap that is not there": (YAML, "  force:", "  pad_gap: 0.02\n  force:",
                               "tool.pad_gap: 'left_finger' reaches over the face of its pad"),
    "a tip beside the middle": (YAML, "xyz: [0, 0, 0.54], rpy: [0, 0, 0]}\n  fingers",
                                "xyz: [0, 0.05, 0.54], rpy: [0, 0, 0]}\n  fingers",
                                "tool.fingers: both stand on one side of T_hand_tip"),
    "a lead that is too short": (YAML, "lead: 0.5", "lead: 0.3",
                                 "devices.fingers.lead: expected at least 0.4 s, which the fingers need"),
    "a device for cups": (YAML, "kind: gripper, lead", "kind: tool_actuator, lead",
                          "devices.fingers.kind: expected gripper, which moves this tool"),
    "no action for a state": (YAML, '["open", "half", "closed"]', '["open", "closed"]',
                              "devices.fingers.actions: no action leads to half"),
    "a finger in the posture": (YAML, "  without: [lance]\n",
                                "  without: [lance]\n  posture: {left_slide: 0.0}\n",
                                "robot.posture.left_slide: is the tool's; where it stands its states say"),
    "no shape on a finger": (URDF, '<collision name="left"><origin xyz="0 0.006 0.04"/><geometry>'
                             '<box size="0.02 0.012 0.08"/></geometry></collision>', "",
                             "tool.fingers[0]: 'left_finger' has no collision shape"),
    "a tip that turns on a finger": (URDF, '<link name="left_finger">', AS_LINK.format(kind="revolute"),
                                     "tool.fingers[0]: 'left_mounted' moves 'left_mount' on 'left_finger'"),
    "the name of the tip": (URDF, '<link name="left_finger">', '<link name="hand_tip"/>\n<joint name="t" '
                            'type="fixed"><parent link="hand"/><child link="hand_tip"/></joint>\n'
                            '<link name="left_finger">',
                            "'hand_tip' is what the frame between the pads is called"),
}  # fmt: skip


@pytest.mark.parametrize("what", MISTAKES)
def test_mistakes_are_told_where_they_stand(cell_copy: CellCopy, refused: Refused, what: str) -> None:
    file, old, new, problem = MISTAKES[what]
    copy = with_gripper(cell_copy)
    (gripper_urdf(copy) if file == URDF else copy.yaml).replace(old, new)
    assert problem in refused(copy.load)


@pytest.mark.parametrize(("closed", "least"), [("0.0", 0.4), ("0.02", 0.3), ("0.03", 0.25)])
def test_fingers_have_as_long_as_the_widest_way_between_their_states_takes(
    cell_copy: CellCopy, refused: Refused, closed: str, least: float
) -> None:
    """Open at 80 mm, and 0.2 m/s of both together."""
    copy = with_gripper(cell_copy)
    copy.yaml.replace("closed: 0.0}", f"closed: {closed}}}")
    copy.yaml.replace("lead: 0.5", f"lead: {least + 1e-6}")
    copy.load()
    copy.yaml.replace(f"lead: {least + 1e-6}", f"lead: {least - 1e-3}")
    assert f"fingers.lead: expected at least {least:g} s" in refused(copy.load)


def test_what_is_moved_by_fingers_is_in_the_fingerprint_and_what_they_bear_is_not(
    cell_copy: CellCopy,
) -> None:
    copy = with_gripper(cell_copy)
    before = copy.load().fingerprint
    copy.yaml.replace("force: 40.0", "force: 41.0")
    assert copy.load().fingerprint == before
    copy.yaml.replace("half: 0.04", "half: 0.05")
    assert copy.load().fingerprint != before


def test_a_square_pad_twists_by_what_the_books_say() -> None:
    assert_allclose(mean_distance(1.0, 1.0), 0.382597858, rtol=1e-8)


@given(st.floats(0.002, 0.1), st.floats(0.002, 0.1))
def test_the_mean_distance_is_that_of_points_all_over_the_pad(a: float, b: float) -> None:
    n = 200
    at = (np.arange(n) + 0.5) / n - 0.5
    assert_allclose(mean_distance(a, b), np.hypot(*np.meshgrid(a * at, b * at)).mean(), rtol=1e-3)


LIMITS = PinchLimits(FORCE, FRICTION, PAD)
HAND_CALCULATED = {
    # two pads of 40 N with friction 0.5 bear 40 N along them, in every direction
    "shear along z": ((0.0, 0.0, 20.0, 0.0, 0.0, 0.0), 0.5),
    "shear askew": ((24.0, 0.0, -32.0, 0.0, 0.0, 0.0), 1.0),
    # friction with a mean lever of 0.3826 * 20 mm = 7.652 mm on both pads: 0.30608 Nm
    "twist": ((0.0, 0.0, 0.0, 0.0, 0.30608, 0.0), 1.0),
    "shear and twist": ((24.0, 0.0, 0.0, 0.0, 0.8 * 0.30608, 0.0), 1.0),
    # along y a pad lifts when the other bears both forces, 80 N
    "force along y": ((0.0, -40.0, 0.0, 0.0, 0.0, 0.0), 0.5),
    # all pressure at an edge, 10 mm from the middle of both pads: 0.8 Nm
    "bending about x": ((0.0, 0.0, 0.0, 0.4, 0.0, 0.0), 0.5),
    "bending about z and force along y": ((0.0, 40.0, 0.0, 0.0, 0.0, -0.4), 1.0),
    # 0.5 kg at 0.1 m along the pads: 4.905 N and a twist of 0.4905 Nm, which slips
    "a heavy lever": ((0.0, 0.0, 4.905, 0.0, 0.4905, 0.0), np.hypot(4.905 / 40.0, 0.4905 / 0.30608)),
}


@pytest.mark.parametrize("what", HAND_CALCULATED)
def test_what_pads_bear_is_what_a_hand_calculates(what: str) -> None:
    wrench, ratio = HAND_CALCULATED[what]
    assert_allclose(LIMITS.ratio(np.array(wrench)), ratio, rtol=1e-4)


@given(st.lists(st.floats(-50.0, 50.0), min_size=6, max_size=6), st.floats(0.1, 10.0))
def test_a_load_grows_with_its_wrench_and_has_no_side(wrench: list[float], by: float) -> None:
    w = np.array(wrench)
    assert_allclose(LIMITS.ratio(by * w), by * LIMITS.ratio(w), rtol=1e-9)
    assert_allclose(LIMITS.ratio(-w), LIMITS.ratio(w))


@given(
    st.lists(st.floats(-50.0, 50.0), min_size=6, max_size=6),
    st.tuples(*[st.floats(0.0, 0.02)] * 3),
    st.lists(st.floats(-1.0, 1.0), min_size=3, max_size=3),
)
def test_no_place_of_the_centre_within_its_strays_loads_more(
    wrench: list[float], stray: tuple[float, float, float], at: list[float]
) -> None:
    """The same forces at a centre elsewhere, with the torques about the tip that they have there."""
    w = np.array(wrench)
    there = np.append(w[:3], w[3:] + np.cross(np.array(at) * stray, w[:3]))
    bound = replace(LIMITS, stray=stray).ratio(w)
    assert LIMITS.ratio(there) <= bound * (1.0 + 1e-9)
    assert LIMITS.ratio(w) <= bound
