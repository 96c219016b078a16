"""A copy of the default cell with a parallel gripper on a stem, as long as the lance it stands in for."""

from __future__ import annotations

import re

from pickcli.cell.tool import ToolState
from support.cell_copies import CellCopy, Editable

OPEN, CLOSED, HALF = ToolState("open"), ToolState("closed"), ToolState("half")
FORCE, FRICTION, PAD = 40.0, 0.5, (0.02, 0.02)  # N, -, m
WIDEST, HALF_WIDE = 0.08, 0.04  # m
LEAD = 0.5  # s

GRIPPER_URDF = """<robot name="gripper">
<link name="hand">
  <inertial><origin xyz="0 0 0.3"/><mass value="0.9"/><inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.001"/></inertial>
  <collision name="mount"><origin xyz="0 0 0.03"/><geometry><cylinder radius="0.045" length="0.06"/></geometry></collision>
  <collision name="stem"><origin xyz="0 0 0.24"/><geometry><cylinder radius="0.0125" length="0.36"/></geometry></collision>
  <collision name="palm"><origin xyz="0 0 0.445"/><geometry><box size="0.03 0.12 0.05"/></geometry></collision>
</link>
<link name="left_finger">
  <inertial><origin xyz="0 0.006 0.04"/><mass value="0.05"/><inertia ixx="1e-5" ixy="0" ixz="0" iyy="1e-5" iyz="0" izz="1e-5"/></inertial>
  <collision name="left"><origin xyz="0 0.006 0.04"/><geometry><box size="0.02 0.012 0.08"/></geometry></collision>
</link>
<link name="right_finger">
  <inertial><origin xyz="0 -0.006 0.04"/><mass value="0.05"/><inertia ixx="1e-5" ixy="0" ixz="0" iyy="1e-5" iyz="0" izz="1e-5"/></inertial>
  <collision name="right"><origin xyz="0 -0.006 0.04"/><geometry><box size="0.02 0.012 0.08"/></geometry></collision>
</link>
<joint name="left_slide" type="prismatic">
  <parent link="hand"/><child link="left_finger"/><origin xyz="0 0 0.47"/><axis xyz="0 1 0"/>
  <limit lower="0" upper="0.04" effort="40" velocity="0.2"/>
</joint>
<joint name="right_slide" type="prismatic">
  <parent link="hand"/><child link="right_finger"/><origin xyz="0 0 0.47"/><axis xyz="0 -1 0"/>
  <limit lower="0" upper="0.04" effort="40" velocity="0.2"/>
  <mimic joint="left_slide"/>
</joint>
</robot>
"""  # noqa: E501

TOOL = f"""tool:
  kind: gripper
  urdf: gripper.urdf
  flange_link: link_t
  hand_link: hand
  T_hand_tip: {{xyz: [0, 0, 0.54], rpy: [0, 0, 0]}}
  fingers: [left_finger, right_finger]
  states: {{open: {WIDEST}, half: {HALF_WIDE}, closed: 0.0}}
  pad_size: [{PAD[0]}, {PAD[1]}]
  force: {FORCE}
  friction: {FRICTION}
  closing_speed: 0.2
  contact_speed: 0.1

"""


def with_gripper(copy: CellCopy) -> CellCopy:
    """The copy with the gripper in place of lance and cup, and without what is for a cup that is down."""
    (copy.folder / "gripper.urdf").write_text(GRIPPER_URDF)
    text = copy.yaml.path.read_text()
    text = re.sub(r"^tool:\n(  .*\n)+\n", TOOL, text, flags=re.MULTILINE)
    text = re.sub(r"  - \{name: \w+, kind: \w+, tool_state: down, [^\n]*\n", "", text)
    text = text.replace("tool_state: straight", "tool_state: open").replace("b: lance", "b: hand")
    text = text.replace("  urdf: robot.urdf\n", "  urdf: robot.urdf\n  without: [lance]\n")
    text = text.replace(", cup_pivot: 20}", "}")
    devices = f'devices:\n  fingers: {{kind: gripper, lead: {LEAD}, actions: ["open", "half", "closed"]}}\n\n'
    text = re.sub(r"^devices:\n(  .*\n)+\n", devices, text, flags=re.MULTILINE)
    copy.yaml.path.write_text(text)
    return copy


def gripper_urdf(copy: CellCopy) -> Editable:
    """The URDF of the gripper, to break."""
    return Editable(copy.folder / "gripper.urdf")
