"""Mistakes in cell.yaml: units, geometry that contradicts itself, names, YAML."""

from __future__ import annotations

from support.user_mistakes.mistake import Mistake, Replacement

BASE = "T_world_base: {xyz: [-1.758, 0, 0], rpy: [0, 0, 0]}"
INNER = "inner: {lower: [-1.315, -0.796, 0.580], upper: [-0.776, -0.437, 0.781]}"
JOINT_S = "joint_s: {has_velocity_limits: true, max_velocity: 2.2, has_acceleration_limits: true"
HOME = "{name: home, kind: home, tool_state: straight, q: [0.1580, 0.0000, -0.3000, 0.0000, -1.9000"
BIN_L = "{name: bin_L, kind: bin, tool_state: straight, q: [0.0908, -0.3706"
BIN_C = "{name: bin_C, kind: bin, tool_state: straight, q: [0.0908, -0.4187"
PUMP = "pump: {kind: pump, lead: 2.0"
TABLE = "{name: table, lower: [-1.742, -0.934, 0.0], upper: [-0.712, -0.404, 0.567]}"
ROW_A = "{bins: [bin_A, bin_B, bin_C], lip_top: 1.5536, hanging_lip: 1.7855, floor_front: 1.5428"


def _cell(name: str, told: str, *changes: Replacement, strict: bool = False) -> Mistake:
    """A mistake in cell.yaml that ``apc check`` finds; with ``--strict`` where it may be meant."""
    return Mistake(name, "check CELL --poses 4" + " --strict" * strict, told, cell=changes)


CELL_MISTAKES = (
    _cell(
        "pod width in mm",
        "pod.width: expected m, outside, along y: less … to 10, got 879.5; lengths are in m, not mm",
        ("width: 0.8795", "width: 879.5"),
    ),
    _cell(
        "cup length in mm",
        "tool.cup_length: expected m, origin of its … to 0.5, got 30; lengths are in m, not mm",
        ("cup_length: 0.03 ", "cup_length: 30 "),
    ),
    _cell(
        "cup radius in mm",
        "tool.cup_radius: expected a value in m: less … to 0.5, got 15; lengths are in m, not mm",
        ("cup_radius: 0.015", "cup_radius: 15"),
    ),
    _cell(
        "cup stroke in mm",
        "tool.cup_stroke: expected m, how far the … to 0.5, got 8; lengths are in m, not mm",
        ("cup_stroke: 0.008", "cup_stroke: 8"),
    ),
    _cell(
        "cup tilt in degrees",
        "tool.cup_tilt: expected rad, how far from … 0.35, got 7; angles are in rad, not degrees",
        ("cup_tilt: 0.12 ", "cup_tilt: 7 "),
    ),
    _cell(
        "pod height in cm",
        "pod.height: expected m, outside: less than or … to 10, got 236.73; lengths are in m, not mm",
        ("height: 2.3673", "height: 236.73"),
    ),
    _cell(
        "board thickness in mm",
        "pod.board_thickness: expected a value in m: … to 0.5, got 1; lengths are in m, not mm",
        ("board_thickness: 0.001", "board_thickness: 1"),
    ),
    _cell(
        "floor slope in degrees",
        "pod.floor_slope: expected rad, how steeply … 0.7, got 5; angles are in rad, not degrees",
        ("floor_slope: 0.08726646", "floor_slope: 5"),
    ),
    _cell(
        "tote inner with x and y swapped",
        "tote.inner: puts the walls at x from -0.799 … -1.354 to -0.737; correct one of the two",
        (INNER, "inner: {lower: [-0.796, -1.315, 0.580], upper: [-0.437, -0.776, 0.781]}"),
    ),
    _cell(
        "base with x and y swapped",
        "robot.T_world_base: the arm reaches none of … (x, y, z in m, roll, pitch, yaw in rad)",
        (BASE, "T_world_base: {xyz: [0, -1.758, 0], rpy: [0, 0, 0]}"),
    ),
    _cell(
        "base turned away from the shelf",
        "robot.T_world_base: the arm reaches none of … (x, y, z in m, roll, pitch, yaw in rad)",
        (BASE, "T_world_base: {xyz: [-1.758, 0, 0], rpy: [0, 0, 3.14159]}"),
    ),
    _cell(
        "base turned by a quarter",
        "configurations[0].q: home is not free, tool … T_world_base, T_world_pod and the obstacles",
        (BASE, "T_world_base: {xyz: [-1.758, 0, 0], rpy: [0, 0, 1.5708]}"),
    ),
    _cell(
        "base's angle in degrees",
        "robot.T_world_base.rpy[2]: expected angles … got 180; angles are in rad, not degrees",
        (BASE, "T_world_base: {xyz: [-1.758, 0, 0], rpy: [0, 0, 180]}"),
    ),
    _cell(
        "base in mm",
        "robot.T_world_base.xyz[0]: expected a … -100, got -1758; lengths are in m, not mm",
        (BASE, "T_world_base: {xyz: [-1758, 0, 0], rpy: [0, 0, 0]}"),
    ),
    _cell(
        "base's sign forgotten",
        "robot.T_world_base: the arm reaches none of … (x, y, z in m, roll, pitch, yaw in rad)",
        (BASE, "T_world_base: {xyz: [1.758, 0, 0], rpy: [0, 0, 0]}"),
    ),
    _cell(
        "base too far away",
        "robot.T_world_base: the arm reaches none of … (x, y, z in m, roll, pitch, yaw in rad)",
        (BASE, "T_world_base: {xyz: [-4.758, 0, 0], rpy: [0, 0, 0]}"),
    ),
    _cell(
        "base sunk into the floor",
        "configurations[0].q: home is not free, tool … T_world_base, T_world_pod and the obstacles",
        (BASE, "T_world_base: {xyz: [-1.758, 0, -0.6], rpy: [0, 0, 0]}"),
    ),
    _cell(
        "base upside down",
        "robot.T_world_base: the arm reaches none of … (x, y, z in m, roll, pitch, yaw in rad)",
        (BASE, "T_world_base: {xyz: [-1.758, 0, 0], rpy: [3.14159, 0, 0]}"),
    ),
    _cell(
        "base's pose with two numbers",
        "robot.T_world_base.xyz: expected a position … in m: at least 3 entries, got 2; correct it",
        (BASE, "T_world_base: {xyz: [-1.758, 0], rpy: [0, 0, 0]}"),
    ),
    _cell(
        "pod lying on its side",
        "pod.T_world_pod: the shelf leans by 90 … in it any more; is rpy in rad, roll first?",
        (
            "T_world_pod: {xyz: [0, 0, 0], rpy: [0, 0, 0]}",
            "T_world_pod: {xyz: [0, 0, 0], rpy: [1.5708, 0, 0]}",
        ),
        strict=True,
    ),
    _cell(
        "pod turned with its back to the robot",
        "configurations[0].q: home is not free, tool … T_world_base, T_world_pod and the obstacles",
        (
            "T_world_pod: {xyz: [0, 0, 0], rpy: [0, 0, 0]}",
            "T_world_pod: {xyz: [0, 0, 0], rpy: [0, 0, 3.14159]}",
        ),
    ),
    _cell(
        "pod on the robot",
        "configurations[0].q: home is not free, tool … T_world_base, T_world_pod and the obstacles",
        ("T_world_pod: {xyz: [0, 0, 0], rpy: [0, 0, 0]}", "T_world_pod: {xyz: [-1.2, 0, 0], rpy: [0, 0, 0]}"),
    ),
    _cell(
        "pod two metres too high",
        "robot.T_world_base: bin_A has the tip at … and the URDF's axes say where things are?",
        ("T_world_pod: {xyz: [0, 0, 0], rpy: [0, 0, 0]}", "T_world_pod: {xyz: [0, 0, 2], rpy: [0, 0, 0]}"),
        strict=True,
    ),
    _cell(
        "displacement in mm",
        "pod.displacement.x: expected m, 0 to 0.5: … to 0.5, got 50; lengths are in m, not mm",
        ("displacement: {x: 0.05, y: 0.05", "displacement: {x: 50, y: 50"),
    ),
    _cell(
        "displacement's yaw in degrees",
        "pod.displacement.yaw: expected rad, 0 to 0.5: … 0.5, got 3; angles are in rad, not degrees",
        ("yaw: 0.0523598776", "yaw: 3"),
    ),
    _cell(
        "lip above the hanging lip",
        "pod.rows[0]: expected floor_front < lip_top < … 1.7856, 1.7855, 1.8086; correct them",
        ("lip_top: 1.5536", "lip_top: 1.7856"),
    ),
    _cell(
        "rows from below",
        "pod.rows[1].ceiling_front: expected the … it, floor_front above or board_thickness",
        (ROW_A, ROW_A.replace("1.5428", "0.8189")),
    ),
    _cell(
        "ceiling that is not the board above",
        "pod.rows[2].ceiling_front: expected the … it, floor_front above or board_thickness",
        ("floor_front: 1.3142", "floor_front: 1.2142"),
    ),
    _cell(
        "divider beyond the post",
        "pod.post: puts it at 0.4043 m, expected beyond 0.4554 m (divider); correct one of the two",
        ("divider: 0.1494", "divider: 0.4494"),
    ),
    _cell(
        "divider given as the width of the middle column",
        "pod.post: puts it at 0.4043 m, expected beyond 0.406 m (divider); correct one of the two",
        ("divider: 0.1494", "divider: 0.40"),
    ),
    _cell(
        "back wall before the lip",
        "pod.back_wall: puts it at 0.0436 m, expected … m (floor_slope); correct one of the two",
        ("back_wall: 0.4361", "back_wall: 0.0436"),
    ),
    _cell(
        "one bin twice",
        "pod.rows[1].bins[2]: the name 'bin_E' stands twice; rename one",
        ("[bin_D, bin_E, bin_F]", "[bin_D, bin_E, bin_E]"),
    ),
    _cell(
        "four bins in a row",
        "pod.rows[1].bins: expected three bin names, … right: at most 3 entries, got 4; correct it",
        ("[bin_D, bin_E, bin_F]", "[bin_D, bin_E, bin_F, bin_M]"),
    ),
    _cell(
        "bins by letters only",
        "pod.rows[1].bins[1]: expected text in quotes, got 5; correct it",
        ("[bin_D, bin_E, bin_F]", "[bin_D, 5, bin_F]"),
    ),
    _cell(
        "home in the shelf",
        "configurations[0].q: home is not free, tool … 178 mm deep; move it, or what it meets",
        (
            HOME,
            HOME.replace(
                "0.1580, 0.0000, -0.3000, 0.0000, -1.9000", "1.0000, 0.0299, 0.4901, 0.0052, -1.1314"
            ),
        ),
    ),
    _cell(
        "home in degrees",
        "configurations[0].q[2]: expected joint_l in … got -17.2; angles are in rad, not degrees",
        (HOME, HOME.replace("-0.3000", "-17.2")),
    ),
    _cell(
        "a configuration one number short",
        "configurations[0].q: expected 8 numbers, one per planned joint, got 7",
        (HOME + ", 0.0000", HOME),
    ),
    _cell(
        "a configuration with a word",
        'configurations[0].q[2]: expected one number … a valid number, got "left"; correct it',
        (HOME, HOME.replace("-0.3000", "left")),
    ),
    _cell(
        "two configurations of one name",
        "configurations[12].name: the name 'bin_C' stands twice; rename one",
        (BIN_L, BIN_L.replace("bin_L", "bin_C")),
    ),
    _cell(
        "a configuration of an unknown kind",
        'configurations[12].kind: expected home, bin, … or yardstick, got "shelf"; correct it',
        (BIN_L, BIN_L.replace("kind: bin", "kind: shelf")),
    ),
    _cell(
        "a configuration in an unknown state",
        "configurations[12].tool_state: no state of … is named 'strait'; did you mean 'straight'?",
        (BIN_L, BIN_L.replace("straight", "strait")),
    ),
    _cell(
        "a configuration before the wrong bin",
        "configurations[3].q: bin_C has the tip at … 1.38, 1.66], 2.35 m from the mouth of bin_C",
        (BIN_C, BIN_C.replace("-0.4187", "1.4187")),
        strict=True,
    ),
    _cell(
        "a bin without a configuration",
        "configurations: none of kind bin is called bin_L; apc suggest-configurations finds one",
        (BIN_L, BIN_L.replace("bin_L", "bin_Z")),
        strict=True,
    ),
    _cell(
        "no home",
        "configurations: none is of kind home, where picks begin and trials end; add one",
        ("{name: home, kind: home", "{name: home, kind: midway"),
        strict=True,
    ),
    _cell(
        "no pump",
        "devices: no pump is among them, and nothing can be picked without one; add it",
        ('  pump: {kind: pump, lead: 2.0, flow: 600, actions: ["on", "off"]}', "#"),
        strict=True,
    ),
    _cell(
        "pump's lead in ms",
        "devices.pump.lead: expected s from the … to 30, got 2000; times are in s, not ms",
        (PUMP, PUMP.replace("2.0", "2000")),
    ),
    _cell(
        "pump's lead of half a minute",
        "devices.pump.lead: 25 s pass before every pick until it takes effect; is it in s?",
        (PUMP, PUMP.replace("2.0", "25")),
        strict=True,
    ),
    _cell(
        "pump's lead negative",
        "devices.pump.lead: expected s from the … than or equal to 0, got -2; correct it",
        (PUMP, PUMP.replace("2.0", "-2")),
    ),
    _cell(
        "pump called a vacuum",
        "devices.pump.kind: expected pump, valve, … correct it",
        (PUMP, PUMP.replace("kind: pump", "kind: vacuum")),
    ),
    _cell(
        "actions without quotes",
        "devices.vacuum_sensor.actions[0]: expected a … got on; write true or false, or quote it",
        (
            'vacuum_sensor: {kind: sensor, lead: 0.0, actions: ["read"]}',
            "vacuum_sensor: {kind: sensor, lead: 0.0, actions: [on]}",
        ),
    ),
    _cell(
        "a pump that cannot be switched on",
        "devices.pump.actions: a pump is switched by on and off; name its actions so",
        (PUMP + ', flow: 600, actions: ["on", "off"]}', PUMP + ', actions: ["start", "stop"]}'),
        strict=True,
    ),
    _cell(
        "an actuator without one state",
        "devices.cup_pivot.actions: no action leads to … one by the name of each state of the tool",
        ('actions: ["straight", "down"]', 'actions: ["straight"]'),
    ),
    _cell(
        "seal time in ms",
        "tool.seal_time: expected s at rest on an item … to 10, got 250; times are in s, not ms",
        ("seal_time: 0.25", "seal_time: 250"),
    ),
    _cell(
        "seal time 0",
        "tool.seal_time: the cup moves an item at … it has sealed; state what the vacuum takes",
        ("seal_time: 0.25 ", "seal_time: 0 "),
        strict=True,
    ),
    _cell(
        "max_velocity in deg/s",
        "joint_limits.joint_s.max_velocity: expected … 60, got 126; limits are in rad, not degrees",
        (JOINT_S, JOINT_S.replace("2.2", "126")),
    ),
    _cell(
        "max_velocity in deg/s, a slow joint",
        "joint_limits.joint_s.max_velocity: 45 rad/s … commercial arm; is it in rad, not degrees?",
        (JOINT_S, JOINT_S.replace("2.2", "45")),
        strict=True,
    ),
    _cell(
        "max_acceleration in deg/s2",
        "joint_limits.joint_t.max_acceleration: … got 2573; limits are in rad, not degrees",
        ("max_acceleration: 10.0", "max_acceleration: 2573"),
    ),
    _cell(
        "rail in mm/s",
        "joint_limits.rail.max_velocity: expected at most 20, got 1000; limits are in m, not mm",
        ("max_velocity: 1.0,", "max_velocity: 1000,"),
    ),
    _cell(
        "decimal comma",
        "joint_limits.joint_s.2: unknown key, the rest … number with a decimal comma; write a point",
        (JOINT_S, JOINT_S.replace("2.2", "2,2")),
    ),
    _cell(
        "number as text",
        'joint_limits.joint_s.max_velocity: expected … got "2.2"; write 2.2, without quotes',
        (JOINT_S, JOINT_S.replace("2.2", '"2.2"')),
    ),
    _cell(
        "number with its unit",
        'joint_limits.joint_s.max_velocity: expected a … … got "2.2 rad/s"; write the number alone',
        (JOINT_S, JOINT_S.replace("2.2", "2.2 rad/s")),
    ),
    _cell(
        "limit 0",
        "joint_limits.joint_s.max_velocity: expected a … or rad/s: greater than 0, got 0; correct it",
        (JOINT_S, JOINT_S.replace("2.2", "0")),
    ),
    _cell(
        "limit negative",
        "joint_limits.joint_s.max_velocity: expected a … rad/s: greater than 0, got -2.2; correct it",
        (JOINT_S, JOINT_S.replace("2.2", "-2.2")),
    ),
    _cell(
        "limits of a joint that is not there",
        "joint_limits.joint_s: expected velocity, … limits and none are assumed: add them here",
        ("  joint_s: {has", "  joint_z: {has"),
    ),
    _cell(
        "limit switched off",
        "joint_limits.joint_s.has_velocity_limits: … is assumed), got false; correct it",
        (JOINT_S, JOINT_S.replace("has_velocity_limits: true", "has_velocity_limits: false")),
    ),
    _cell(
        "joints in another order",
        "robot.joints: expected the chain's moving …; write them base outwards",
        ("joints: [rail, joint_s, joint_l,", "joints: [rail, joint_l, joint_s,"),
    ),
    _cell(
        "a joint left out",
        "robot.joints: expected the chain's moving … that stands still is named in robot.posture",
        ("joints: [rail, joint_s, joint_l,", "joints: [rail, joint_l,"),
    ),
    _cell(
        "an obstacle around the base",
        "configurations[0].q: home is not free, tool … T_world_base, T_world_pod and the obstacles",
        (TABLE, TABLE + "\n  - {name: pillar, lower: [-1.9, -0.3, 0.6], upper: [-1.4, 0.3, 1.2]}"),
    ),
    _cell(
        "an obstacle in the shelf's mouth",
        "configurations[0].q: home is not free, tool … T_world_base, T_world_pod and the obstacles",
        (TABLE, TABLE + "\n  - {name: cart, lower: [-0.6, -0.6, 0.0], upper: [-0.02, 0.6, 2.2]}"),
    ),
    _cell(
        "an obstacle over the tote",
        "configurations[27].q: drop_00 is not free, … T_world_base, T_world_pod and the obstacles",
        (TABLE, TABLE + "\n  - {name: lid, lower: [-1.354, -0.804, 0.80], upper: [-0.737, -0.428, 0.82]}"),
    ),
    _cell(
        "an obstacle inside out",
        "obstacles[1]: expected lower under upper, got … 0.0) and (-1.812, -0.404, 0.567); swap them",
        (TABLE, TABLE.replace("upper: [-0.712", "upper: [-1.812")),
    ),
    _cell(
        "an obstacle in mm",
        "obstacles[1].upper[2]: expected the upper … to 100, got 567; lengths are in m, not mm",
        (TABLE, TABLE.replace("0.567", "567")),
    ),
    _cell(
        "two obstacles of one name",
        "obstacles[5].name: the name 'camera' stands twice; rename one",
        ("{name: table,", "{name: camera,"),
    ),
    _cell(
        "an obstacle named as a link",
        "obstacles[1].name: 'link_s' is a link of the robot too; rename the obstacle",
        ("{name: table,", "{name: link_s,"),
    ),
    _cell(
        "an obstacle that cuts through the tote",
        "obstacles[1]: table stands in tote, where items should; correct its corners, or the pose or size of",
        (TABLE, TABLE.replace("0.567", "0.700")),
        strict=True,
    ),
    _cell(
        "clearance in mm",
        "clearance: expected a value in m: less than or equal to 0.1, got 3; lengths are in m, not mm",
        ("clearance: 0.003", "clearance: 3"),
    ),
    _cell(
        "clearance in cm",
        "configurations[0].q: home is not free, tool … T_world_base, T_world_pod and the obstacles",
        ("clearance: 0.003", "clearance: 0.08"),
        strict=True,
    ),
    _cell(
        "clearance 0",
        "clearance: every motion keeps 0 mm from … nothing is left for what a robot is off by",
        ("clearance: 0.003", "clearance: 0"),
        strict=True,
    ),
    _cell(
        "speed in percent",
        "speed_scale: expected a factor in (0, 1]: … to 1, got 50; shares are of 1, not per cent",
        ("speed_scale: 1.0", "speed_scale: 50"),
    ),
    _cell(
        "a tool speed in mm/s",
        "max_tool_speed: expected m/s of the tool's … to 10, got 250; speeds are in m/s, not mm/s",
        ("speed_scale: 1.0", "max_tool_speed: 250\nspeed_scale: 1.0"),
    ),
    _cell(
        "contact speed in mm/s",
        "tool.contact_speed: expected m/s, fastest … to 2, got 75; speeds are in m/s, not mm/s",
        ("contact_speed: 0.075", "contact_speed: 75"),
    ),
    _cell(
        "pull in kg",
        "tool.max_pull: 4.2 N is 5.9 kPa under a cup of 15 mm radius; is it in N, not kg?",
        ("max_pull: 42.0", "max_pull: 4.2"),
        strict=True,
    ),
    _cell(
        "moment in Nmm",
        "tool.max_moment: a cup of 15 mm radius that … off at about 0.63 Nm, not 600; is it in Nm?",
        ("max_moment: 0.6 ", "max_moment: 600 "),
        strict=True,
    ),
    _cell(
        "shear over pull",
        "tool.max_shear: 2100 N across a cup that pulls 42 N needs a friction of 50; correct one",
        ("max_shear: 21.0", "max_shear: 2100"),
        strict=True,
    ),
    _cell(
        "tool's links in another order",
        "tool: expected the chain to end with flange, … and cup link; it ends link_b, link_t, lance",
        ("lance_link: lance", "lance_link: cup"),
        ("cup_link: cup\n", "cup_link: lance\n"),
    ),
    _cell(
        "a tool's link that is not there",
        "tool: expected the chain to end with flange, lance and cup link; it ends rail_base",
        ("cup_link: cup\n", "cup_link: cups\n"),
    ),
    _cell(
        "the tool's state in degrees",
        "tool.states.down: expected positions of that … 6.3, got 90; angles are in rad, not degrees",
        ("down: 1.5707963267948966", "down: 90"),
    ),
    _cell(
        "tote's wall in mm",
        "tote.wall_thickness: expected a value in m: … to 0.5, got 3; lengths are in m, not mm",
        ("wall_thickness: 0.003", "wall_thickness: 3"),
    ),
    _cell(
        "tote upside down",
        "tote.inner: expected lower under upper, got … and (-0.776, -0.437, 0.781); swap them",
        (INNER, INNER.replace("0.580", "0.881")),
    ),
    _cell(
        "tote out of reach",
        "robot.T_world_base: tote has the tip at … and the URDF's axes say where things are?",
        (INNER, "inner: {lower: [-1.315, -2.796, 0.580], upper: [-0.776, -2.437, 0.781]}"),
        (
            "flange: {lower: [-1.354, -0.804, 0.751], upper: [-0.737, -0.428, 0.781]}",
            "flange: {lower: [-1.354, -2.804, 0.751], upper: [-0.737, -2.428, 0.781]}",
        ),
        strict=True,
    ),
    _cell(
        "tote in the shelf",
        "configurations[17].q: cam_E is not free, tool … 20 mm deep; move it, or what it meets",
        (INNER, "inner: {lower: [-0.215, -0.196, 0.980], upper: [0.324, 0.163, 1.181]}"),
        (
            "flange: {lower: [-1.354, -0.804, 0.751], upper: [-0.737, -0.428, 0.781]}",
            "flange: {lower: [-0.254, -0.204, 1.151], upper: [0.363, 0.172, 1.181]}",
        ),
    ),
    _cell(
        "a misspelt key",
        "tool.cup_stroke: expected m, how far the bellows compress, got nothing; add it",
        ("cup_stroke: 0.008", "cup_strok: 0.008"),
    ),
    _cell(
        "a key twice",
        "tool.cup_stroke: stands twice; keep one",
        ("cup_stroke: 0.008", "cup_stroke: 0.008\n  cup_stroke: 0.009"),
    ),
    _cell(
        "a tab",
        "not YAML: found a tab character that violates indentation; indent with spaces, not tabs",
        ("  cup_stroke: 0.008", "\tcup_stroke: 0.008"),
    ),
    _cell(
        "a bracket missing",
        "not YAML: did not find expected ',' or ']'; is a comma missing, or the bracket of … open?",
        (BASE, BASE.replace("0]}", "0}")),
    ),
    _cell(
        "an alias",
        "anchors and aliases are not allowed; write the value out",
        ("speed_scale: 1.0", "speed_scale: &full 1.0"),
    ),
    _cell(
        "a number with an underscore",
        "clearance: expected a number, got 0_003; leave out the underscores",
        ("clearance: 0.003", "clearance: 0_003"),
    ),
    _cell(
        "not a number",
        "clearance: expected a finite number, got .nan; write a finite number",
        ("clearance: 0.003", "clearance: .nan"),
    ),
    _cell(
        "infinity",
        "joint_limits.joint_s.max_velocity: expected a finite number, got .inf; write a finite number",
        (JOINT_S, JOINT_S.replace("2.2", ".inf")),
    ),
    _cell(
        "a version to come",
        "version: expected 2, the only version that is read, got 3; correct it",
        ("version: 2", "version: 3"),
    ),
    _cell(
        "the version before",
        "version: 1 is the version before; rename … of devices to tool_actuator, and write 2",
        ("version: 2", "version: 1"),
    ),
    _cell(
        "another format",
        "cell/cell.yaml: is a scene, but a cell is … of a cell.yaml, or a name under data/cells)",
        ("format: apc cell", "format: apc scene"),
    ),
    _cell(
        "a URDF that is not there",
        "robot.urdf: 'robots.urdf': no such file in the cell's folder; check the name",
        ("urdf: robot.urdf", "urdf: robots.urdf"),
    ),
    _cell(
        "a URDF outside of the folder",
        "robot.urdf: expected a path inside the cell's folder, got '../robot.urdf'; copy it there",
        ("urdf: robot.urdf", "urdf: ../robot.urdf"),
    ),
    _cell(
        "a part of the cell left blank",
        "speed_scale: expected a factor in (0, 1], got nothing; fill it in",
        ("speed_scale: 1.0 ", "speed_scale: "),
    ),
    _cell(
        "an allowed pair of an unknown link",
        "allowed_pairs[0].a: no link is named 'carriages'; did you mean 'carriage'?",
        ("{a: carriage, b: rail_bed,", "{a: carriages, b: rail_bed,"),
    ),
    _cell(
        "an allowed pair without a reason",
        'allowed_pairs[2].reason: expected why they … at least 10 characters, got ""; correct it',
        ('reason: "the drive is part of the rail under the support of the arm"', 'reason: ""'),
    ),
    _cell(
        "an allowed pair of a part of the shelf",
        "allowed_pairs[0].b: no link or obstacle is … link_e, link_l, link_r, link_s, link_t, ...",
        ("{a: carriage, b: rail_bed,", "{a: lance, b: row_ABC_lip,"),
    ),
    _cell(
        "an allowed pair that takes the arm from the table",
        "allowed_pairs[0]: lance and table are apart … where they may meet; leave the pair out",
        (
            "  - {a: carriage, b: rail_bed,",
            '  - {a: lance, b: table, reason: "they never meet"}\n  - {a: carriage, b: rail_bed,',
        ),
        strict=True,
    ),
    _cell(
        "a motor force left out",
        "robot.motor_forces.cup_pivot: expected a force in N or Nm, got nothing; add it",
        ("cup_pivot: 20}", "}"),
    ),
    _cell(
        "a motor's force in Nmm",
        "robot.motor_forces.joint_t: 15000 is more … arms have; is it in N or Nm, not Nmm?",
        ("joint_t: 15,", "joint_t: 15000,"),
        strict=True,
    ),
    _cell(
        "narrowed beyond the URDF",
        "joint_limits.joint_s.max_position: expected … to 3.1415, got -3.1415 to 4; correct them",
        (JOINT_S, JOINT_S.replace("{has", "{max_position: 4, has")),
    ),
    _cell(
        "narrowed in degrees",
        "joint_limits.joint_s.max_position: expected … got -3.1415 to 170; positions are in rad, not degrees",
        (JOINT_S, JOINT_S.replace("{has", "{max_position: 170, has")),
    ),
    _cell(
        "narrowed to almost nothing",
        "configurations[13].q[1]: expected joint_s … got 0.5783; correct it; numbers stand in the order",
        (JOINT_S, JOINT_S.replace("{has", "{min_position: -0.45, max_position: 0.46, has")),
    ),
    _cell(
        "narrowed the wrong way round",
        "joint_limits.joint_s.max_position: … got 1 and -1; swap them",
        (JOINT_S, JOINT_S.replace("{has", "{min_position: 1, max_position: -1, has")),
    ),
    _cell(
        "a speed with a decimal comma, quoted",
        'speed_scale: expected a factor … got "0,5"; write 0.5, with a point',
        ("speed_scale: 1.0", 'speed_scale: "0,5"'),
    ),
    _cell(
        "a speed in per cent",
        'speed_scale: expected a factor … got "50%"; write 0.5, as shares are of 1',
        ("speed_scale: 1.0", "speed_scale: 50%"),
    ),
    _cell(
        "a minus out of a text processor",
        'clearance: … got "\N{MINUS SIGN}0.003"; write -0.003, with the minus … keyboard',
        ("clearance: 0.003", "clearance: \N{MINUS SIGN}0.003"),
    ),
    _cell(
        "a space out of a text processor",
        "not YAML: could not find expected ':'; there is a no-break space in line …; write a usual one",
        ("clearance: 0.003", "clearance:\N{NO-BREAK SPACE}0.003"),
    ),
    _cell(
        "no format",
        "format: expected 'apc cell', got nothing; add it",
        ("format: apc cell\n", ""),
    ),
    _cell(
        "a pair of one link",
        "allowed_pairs[0].b: 'cup' is never tested against itself; name the other one, or delete",
        ("allowed_pairs:\n", "allowed_pairs:\n  - {a: cup, b: cup, reason: a slip of the pen}\n"),
    ),
    _cell(
        "decimal commas in a corner",
        "tote.inner.lower: expected numbers with a decimal point, got [-1, 315, 0, 796, 0, 580]; a comma",
        ("lower: [-1.315, -0.796, 0.580]", "lower: [-1,315, -0,796, 0,580]"),
    ),
    _cell(
        "names of two bins exchanged",
        "configurations[1].q: bin_A has the tip before bin_C, not bin_A; were names exchanged?",
        ("bins: [bin_A, bin_B, bin_C]", "bins: [bin_C, bin_B, bin_A]"),
        strict=True,
    ),
)
