"""Mistakes in a robot's URDF."""

from __future__ import annotations

from support.user_mistakes.mistake import Mistake, Replacement

LIMIT_L = '<limit lower="-1.9198" upper="1.9198" velocity="2.2" effort="550"/>'
SHAPE_CUP = '<geometry><cylinder radius="0.015" length="0.03"/></geometry>'
ORIGIN_E = '<child link="link_e"/>\n    <origin xyz="0 0 0.49" rpy="0 0 0"/>'
INERTIAL_L = """    <inertial>
      <origin xyz="0 -0.0285 0.0845" rpy="-0.3253 0 0"/>
      <mass value="18"/>
      <inertia ixx="0.21039" ixy="0" ixz="0" iyy="0.21039" iyz="0" izz="0.14288"/>
    </inertial>
"""


def _urdf(name: str, told: str, *changes: Replacement, strict: bool = False) -> Mistake:
    """A mistake in the URDF that ``apc check`` finds; with ``--strict`` where it may be meant."""
    return Mistake(name, "check CELL --poses 4" + " --strict" * strict, told, urdf=changes)


URDF_MISTAKES = (
    _urdf(
        "limits in degrees",
        "<limit>: expected within 12.6 of 0, got -110 and 110; limits are in rad, not degrees",
        (LIMIT_L, LIMIT_L.replace("1.9198", "110")),
    ),
    _urdf(
        "limits swapped",
        "<limit>: expected lower under upper, got 1.9198 and -1.9198; swap them",
        (LIMIT_L, LIMIT_L.replace('"-1.9198" upper="1.9198"', '"1.9198" upper="-1.9198"')),
    ),
    _urdf(
        "limits of 180 rad",
        "<limit>: expected within 12.6 of 0, got -180 and 180; limits are in rad, not degrees",
        (LIMIT_L, LIMIT_L.replace("1.9198", "180")),
    ),
    _urdf("no limits", "<joint> 'joint_l': has no <limit>; add it", (LIMIT_L, "")),
    _urdf(
        "limit with a decimal comma",
        "<limit>: upper: expected 1 finite number, got '1,9198'; write a decimal point, no comma",
        (LIMIT_L, LIMIT_L.replace('upper="1.9198"', 'upper="1,9198"')),
    ),
    _urdf(
        "limit not a number",
        "<limit>: upper: expected 1 finite number, got 'nan'",
        (LIMIT_L, LIMIT_L.replace('upper="1.9198"', 'upper="nan"')),
    ),
    _urdf(
        "a link without a mass",
        "robot.urdf: link 'link_l' has no <inertial>, or one of 0 kg: … as heavy as water; state its mass",
        (INERTIAL_L, ""),
        strict=True,
    ),
    _urdf(
        "a negative mass",
        "<mass>: expected a mass of 0 kg or more, got -18",
        ('<mass value="18"/>', '<mass value="-18"/>'),
    ),
    _urdf(
        "a mass in g",
        "<mass>: expected a mass of at most 10000 kg, got 18000",
        ('<mass value="18"/>', '<mass value="18000"/>'),
    ),
    _urdf(
        "an axis of the wrong sign",
        "configurations[32].q: drop_12 is not free, … 72 mm deep; move it, or what it meets",
        (
            '<child link="link_u"/>\n    <origin xyz="0 0 0" rpy="0 0 0"/>\n    <axis xyz="0 -1 0"/>',
            '<child link="link_u"/>\n    <origin xyz="0 0 0" rpy="0 0 0"/>\n    <axis xyz="0 1 0"/>',
        ),
    ),
    _urdf(
        "an axis of zeros",
        "<axis>: the axis has no direction; expected a vector of length 1",
        (
            '<child link="link_u"/>\n    <origin xyz="0 0 0" rpy="0 0 0"/>\n    <axis xyz="0 -1 0"/>',
            '<child link="link_u"/>\n    <origin xyz="0 0 0" rpy="0 0 0"/>\n    <axis xyz="0 0 0"/>',
        ),
    ),
    _urdf(
        "a link in mm",
        "<origin>: expected xyz within 10 m, got (0.0, 0.0, 490.0); lengths are in m, not mm",
        (ORIGIN_E, ORIGIN_E.replace("0.49", "490")),
    ),
    _urdf(
        "a link ten times too long",
        "robot.T_world_base: the arm reaches none of … (x, y, z in m, roll, pitch, yaw in rad)",
        (ORIGIN_E, ORIGIN_E.replace("0.49", "4.9")),
    ),
    _urdf(
        "a turn in degrees",
        "<origin>: expected rpy within 12.6 rad, got (0.0, 90.0, 0.0); angles are in rad, not degrees",
        (ORIGIN_E, ORIGIN_E.replace('rpy="0 0 0"', 'rpy="0 90 0"')),
    ),
    _urdf(
        "a shape in mm",
        "<cylinder>: expected sizes of at most 10 m, got 15.0 0.03; lengths are in m, not mm",
        (SHAPE_CUP, SHAPE_CUP.replace("0.015", "15")),
    ),
    _urdf(
        "a shape of no size",
        "<cylinder>: expected sizes over 0 m, got 0.0 0.03",
        (SHAPE_CUP, SHAPE_CUP.replace("0.015", "0")),
    ),
    _urdf(
        "a negative shape",
        "<cylinder>: expected sizes over 0 m, got -0.015 0.03",
        (SHAPE_CUP, SHAPE_CUP.replace("0.015", "-0.015")),
    ),
    _urdf(
        "a capsule",
        "<capsule>: expected box, cylinder, sphere or mesh; enclose the part in those",
        (SHAPE_CUP, SHAPE_CUP.replace("cylinder", "capsule")),
    ),
    _urdf(
        "a mesh that is not there",
        "<mesh>: … cup.stl: no such file; copy it there or correct the name",
        (SHAPE_CUP, '<geometry><mesh filename="cup.stl"/></geometry>'),
    ),
    _urdf(
        "a mesh of a package that nobody named",
        "<mesh>: package 'cups' is unknown; state its folder as robot.packages.cups",
        (SHAPE_CUP, '<geometry><mesh filename="package://cups/cup.stl"/></geometry>'),
    ),
    _urdf(
        "a parent that is not there",
        "<parent>: no link is named 'link_ll'; add it or correct the name",
        ('<parent link="link_l"/>', '<parent link="link_ll"/>'),
    ),
    _urdf(
        "two joints of one name",
        "<joint> 'joint_u': the name stands in line 160 too; rename one",
        ('<joint name="joint_r" type="revolute">', '<joint name="joint_u" type="revolute">'),
    ),
    _urdf(
        "two links of one name",
        "<link> 'link_u': the name stands in line 168 too; rename one",
        ('<link name="link_r">', '<link name="link_u">'),
    ),
    _urdf(
        "a joint of an unknown type",
        "<joint> 'joint_r': expected type continuous, fixed, prismatic, revolute, got 'hinge'",
        ('<joint name="joint_r" type="revolute">', '<joint name="joint_r" type="hinge">'),
    ),
    _urdf(
        "a joint that floats",
        "<joint> 'joint_r': expected type continuous, fixed, prismatic, revolute, got 'floating'",
        ('<joint name="joint_r" type="revolute">', '<joint name="joint_r" type="floating">'),
    ),
    _urdf(
        "a tag left open",
        "not XML: mismatched tag; a tag is not closed, or the file is cut off",
        ("  </link>\n\n</robot>", "\n</robot>"),
    ),
    _urdf(
        "cut off", "not XML: no element found; a tag is not closed, or the file is cut off", ("</robot>", "")
    ),
    _urdf(
        "a root that is no robot",
        "<sdf> 'sia20f_on_rail': expected <robot> as the outermost element",
        ('<robot name="sia20f_on_rail">', '<sdf name="sia20f_on_rail">'),
        ("</robot>", "</sdf>"),
    ),
    _urdf(
        "a xacro",
        "<xacro:property> 'a': not expanded; run xacro on it, or give it to apc init --urdf",
        (
            '<robot name="sia20f_on_rail">',
            '<robot name="sia20f_on_rail" xmlns:xacro="http://ros.org/wiki/xacro">\n'
            '  <xacro:property name="a" value="1"/>',
        ),
    ),
    _urdf(
        "a link without a shape on a joint",
        "robot.urdf: line 301: link 'cup' is drawn but … <collision>, or name it in robot.unshaped",
        (
            SHAPE_CUP.replace(
                "<geometry>", '    <collision name="cup">\n      <origin xyz="0 0 0.015"/>\n      <geometry>'
            ).replace("</geometry>", "</geometry>\n    </collision>"),
            "    <visual>" + SHAPE_CUP + "</visual>",
        ),
    ),
    _urdf(
        "a fixed joint in the chain",
        "robot.joints: expected the chain's moving … that stands still is named in robot.posture",
        ('<joint name="joint_r" type="revolute">', '<joint name="joint_r" type="fixed">'),
    ),
    _urdf(
        "position with two numbers",
        "<origin>: xyz: expected 3 finite numbers, got '0 0.49'",
        (ORIGIN_E, ORIGIN_E.replace("0 0 0.49", "0 0.49")),
    ),
    _urdf(
        "a link that hangs on nothing",
        "<joint> 'joint_e': link 'link_l' has a second parent; that closes a loop",
        ('<child link="link_e"/>', '<child link="link_l"/>'),
    ),
    _urdf(
        "limits of nothing",
        "<limit>: got -1e+16 and 1e+16 rad; the type of a joint without limits is continuous",
        (LIMIT_L, LIMIT_L.replace("1.9198", "1e16")),
    ),
)
