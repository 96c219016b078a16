"""Exports a program for Universal Robots arms: set points by servoj, devices by digital outputs."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pickcli.cell.robot import JointType, Robot
from pickcli.errors import InputError
from pickcli.export.channels import Channel, channels
from pickcli.export.device_events import DeviceEvent, device_events
from pickcli.export.exporter import Exporter, ExportRequest
from pickcli.export.samples import SECOND
from pickcli.geometry import Array
from pickcli.motion.plan_file import motion_hash

JOINTS = (
    "shoulder_pan_joint",
    "shoulder_lift_joint",
    "elbow_joint",
    "wrist_1_joint",
    "wrist_2_joint",
    "wrist_3_joint",
)
RATES = (125.0, 250.0, 500.0)  # Hz: integer cycles of controllers, which run at 500 Hz, older ones at 125 Hz
LOOKAHEAD, GAIN = 0.03, 300  # s and the controller's unit: the least smoothing that servoj allows
START_TOLERANCE = 0.01  # rad between the arm and the first point, as for apc execute
SETTLE = 0.2  # s at the last point, in which the arm arrives
BRAKING = 2.0  # rad/s^2 of stopj


def _encode(request: ExportRequest) -> bytes:
    plan, robot = request.plan, request.scene.cell.robot
    _refuse_other_arms(robot)
    rate = RATES[0] if request.rate is None else request.rate
    if rate not in RATES:
        raise InputError(f"rate: {rate:g} Hz is no rate of these controllers; name 125, 250 or 500")
    wired = channels(request.scene.cell.devices, request.channels)
    program = [
        *(f"# {line}" for line in _head(request, wired)),
        "def apc_plan():",
        *(
            f"  {line}"
            for line in (*_start_check(plan.trajectory.positions[0]), *_body(request, rate, wired))
        ),
        "end",
        "apc_plan()",
        "",
    ]
    return "\n".join(program).encode("ascii")


def _refuse_other_arms(robot: Robot) -> None:
    """Raise InputError for an arm without the six joints of Universal Robots, with optional prefixes."""
    kinds = {joint.name: joint.type for joint in robot.joints}
    is_theirs = len(robot.joint_names) == len(JOINTS) and all(
        name.endswith(joint) and kinds[name] is not JointType.PRISMATIC
        for name, joint in zip(robot.joint_names, JOINTS, strict=True)
    )
    if not is_theirs:
        raise InputError(
            f"arm {robot.name}: URScript is for the six joints of Universal Robots ({', '.join(JOINTS)}), "
            f"this arm has {', '.join(robot.joint_names)}; export to another format"
        )


def _head(request: ExportRequest, wired: dict[str, Channel]) -> Iterator[str]:
    plan = request.plan
    yield f"Written by apc export: {_ascii(plan.query)}"
    cell = f"cell {_ascii(request.scene.cell.name)} {plan.cell_fingerprint[:12]}"
    yield f"{cell}, motion {motion_hash(plan)[:12]}"
    for name, channel in wired.items():
        if channel.is_input:
            yield f"digital input {channel.number}: {_ascii(name)}, on where something is held"
        else:
            yield f"digital output {channel.number}: {_ascii(name)}, on for {_ascii(channel.action_on)}"


def _start_check(first: Array) -> Iterator[str]:
    """Lines that stop the program if the arm is not at the first point."""
    yield f"local first = {_joints(first)}"
    yield "local here = get_actual_joint_positions()"
    yield "local k = 0"
    yield "while k < 6:"
    yield f"  if norm(here[k] - first[k]) > {START_TOLERANCE}:"
    yield f"    {_popup('The arm does not stand at the first point of the plan.')}"
    yield "    halt"
    yield "  end"
    yield "  k = k + 1"
    yield "end"


def _body(request: ExportRequest, rate: float, wired: dict[str, Channel]) -> Iterator[str]:
    """One line for each set point, preceded by those of the events due at that time."""
    trajectory = request.plan.trajectory
    events = device_events(request.plan, request.scene.cell)
    due = [round(event.nanoseconds * rate / SECOND) for event in events]
    n_moving = int(np.ceil(trajectory.duration * rate - 1e-6))
    n_steps = max([n_moving, *due]) + round(SETTLE * rate)
    points = trajectory.sample(np.minimum(np.arange(1, n_steps + 1) / rate, trajectory.duration))
    points[n_moving - 1 :] = trajectory.positions[-1]
    for step, q in enumerate(points):
        for event in (event for event, at in zip(events, due, strict=True) if at == step):
            yield from _switch(event, wired[event.device])
        yield f"servoj({_joints(q)}, t={1.0 / rate:g}, lookahead_time={LOOKAHEAD:g}, gain={GAIN})"
    yield f"stopj({BRAKING:g})"


def _switch(event: DeviceEvent, channel: Channel) -> Iterator[str]:
    if not channel.is_input:
        yield f"set_standard_digital_out({channel.number}, {event.action == channel.action_on})"
        return
    yield f"if not get_standard_digital_in({channel.number}):"
    yield f"  stopj({BRAKING:g})"
    yield f"  {_popup(f'{_ascii(event.device)}: nothing is held.')}"
    yield "  halt"
    yield "end"


def _popup(message: str) -> str:
    return f'popup("{message}", "apc", error=True, blocking=True)'


def _joints(q: Array) -> str:
    return "[" + ", ".join(f"{value:.10f}" for value in (np.round(q, 10) + 0.0).tolist()) + "]"


def _ascii(text: str) -> str:
    """Replace quotes and all characters other than printable ASCII by "?"."""
    return "".join(c if " " <= c <= "~" and c not in '"\\' else "?" for c in text)


EXPORTER = Exporter(
    "a program for arms of Universal Robots: servoj and digital outputs",
    ".script",
    _encode,
    has_channels=True,
)
