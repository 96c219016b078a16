"""Plans as JSON files: written whole or not at all, read strictly. See docs/formats/plan.md.

Floats are written with all significant digits, so a plan that is written and read again is the same plan bit
for bit, and has the same ``motion_hash``.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from pickcli.cell.fingerprint import digest
from pickcli.errors import DamagedError, InputError
from pickcli.files.atomic_write import write_bytes
from pickcli.files.bounded_reading import read_text
from pickcli.files.file_kind import PLAN
from pickcli.geometry import Array
from pickcli.motion.plan import Plan
from pickcli.motion.plan_schema import FORMAT, VERSION, parse_plan, plain
from pickcli.motion.trajectory import Trajectory

MAX_BYTES = 24 * 2**20  # a plan of ten seconds has half a megabyte


def motion_hash(plan: Plan) -> str:
    """Compute the SHA-256 of the motion: trajectory, segments, events, grasp, level of recovery and conveyor.

    Args:
        plan: The plan.

    Returns:
        Hexadecimal digits.
    """
    return digest({
        "trajectory": _trajectory(plan.trajectory),
        "segments": [plain(segment) for segment in plan.segments],
        "events": [plain(event) for event in plan.events],
        "grasp": plain(plan.grasp),
        "recovery": plain(plan.recovery),
        **_tracking(plan),
        **_upright(plan),
    })  # fmt: skip


def plan_to_dict(plan: Plan) -> dict[str, Any]:
    """Convert a plan to the JSON object of its file.

    Args:
        plan: The plan.

    Returns:
        JSON values, keys in the file's order.
    """
    return {
        "format": FORMAT,
        "version": VERSION,
        "query": plan.query,
        "cell_fingerprint": plan.cell_fingerprint,
        "scene_hash": plan.scene_hash,
        "seed": plan.seed,
        "speed_scale": plan.speed_scale,
        "recovery": plain(plan.recovery),
        **_arms(plan),
        **_tracking(plan),
        **_upright(plan),
        "grasp": plain(plan.grasp),
        "segments": [plain(segment) for segment in plan.segments],
        "events": [plain(event) for event in plan.events],
        "trajectory": _trajectory(plan.trajectory),
        "certificate": None
        if plan.certificate is None
        else {**plain(plan.certificate), "seal": certificate_seal(plan)},
        "statistics": dict(sorted(plan.statistics.items())),
    }


def write_plan(plan: Plan, path: Path, replace: bool = True) -> None:
    """Write a plan's file in one step: a kill or a full disk leaves the old file or none.

    Args:
        plan: The plan.
        path: The file.
        replace: Whether a file that exists may be replaced.

    Raises:
        InputError: If the plan holds a number that JSON cannot represent (nan, infinity), or the file cannot
            be written.
    """
    try:
        text = _layout(plan_to_dict(plan))
    except ValueError as error:
        raise InputError(f"{path}: a number of the plan is not finite ({error}); not written") from error
    write_bytes(path, text.encode(), replace)


def read_plan(path: Path) -> Plan:
    """Read a plan's file, strictly.

    Args:
        path: The file.

    Returns:
        The plan.

    Raises:
        InputError: If the file is missing, too large, or breaks the format (all problems at once, each with
            its field).
        StaleError: If it is of another version of the format.
        DamagedError: If the file was changed after it was certified.
    """
    text = read_text(path, MAX_BYTES, "plan one with apc plan-pick", PLAN)
    plan, seal = parse_plan(text, str(path))
    _check_certificate(plan, seal, str(path))
    return plan


def certificate_seal(plan: Plan) -> str:
    """Compute the SHA-256 of a certificate and of the whole plan except ``statistics``.

    Anyone who can edit the file can compute it: it reveals damage and mix-ups, and is not a signature.

    Args:
        plan: A plan with a certificate.

    Returns:
        Hexadecimal digits.
    """
    parts = (plan.query, plan.cell_fingerprint, plan.scene_hash, plan.seed, plan.speed_scale)
    return digest([*parts, *_arms(plan).items(), motion_hash(plan), plain(plan.certificate)])


def _arms(plan: Plan) -> dict[str, Any]:
    """Return the moving arm and the states of the others; {} in a cell with one arm."""
    return {"arm": plan.arm, "others": [plain(state) for state in plan.others]} if plan.arm else {}


def _upright(plan: Plan) -> dict[str, Any]:
    """Return the entry for the bound of the tilt, if there is one."""
    return {} if plan.upright is None else {"upright": plan.upright}


def _tracking(plan: Plan) -> dict[str, Any]:
    """Return the running conveyor; {} for a plan whose items stand."""
    return {} if plan.tracking is None else {"tracking": plain(plan.tracking)}


def _check_certificate(plan: Plan, seal: str, where: str) -> None:
    """Raise DamagedError if the plan's data are not those that were certified."""
    if plan.certificate is None:
        return
    pairs = (
        ("motion_hash", plan.certificate.motion_hash, motion_hash(plan)),
        ("scene_hash", plan.certificate.scene_hash, plan.scene_hash),
        ("cell_fingerprint", plan.certificate.cell_fingerprint, plan.cell_fingerprint),
        ("seal", seal, certificate_seal(plan)),
    )
    for name, certified, found in pairs:
        if certified != found:
            raise DamagedError(
                f"{where}: certificate.{name}: edited after it was certified "
                f"(certified {certified[:12]}, found {found[:12]}); plan it again, or set its certificate to "
                "null and verify it"
            )


def _rows(a: Array) -> list[Any]:
    """Convert an array to nested lists of Python floats."""
    return list(a.tolist())


def _trajectory(trajectory: Trajectory) -> dict[str, Any]:
    """Convert to trajectory_msgs/JointTrajectory, but with time_from_start in s as one float."""
    names = ("positions", "velocities", "accelerations", "time_from_start")
    columns = (trajectory.positions, trajectory.velocities, trajectory.accelerations, trajectory.times)
    points = zip(*(_rows(column) for column in columns), strict=True)
    return {
        "joint_names": list(trajectory.joint_names),
        "points": [dict(zip(names, point, strict=True)) for point in points],
    }


def _layout(data: dict[str, Any]) -> str:
    """Format JSON for people and diffs: one line per point, segment and event instead of one per number."""

    def line(value: Any) -> str:
        return json.dumps(value, allow_nan=False)

    def block(value: Any, indent: str) -> str:
        if isinstance(value, list) and value and isinstance(value[0], dict):
            rows = f",\n{indent}  ".join(line(v) for v in value)
            return f"[\n{indent}  {rows}\n{indent}]"
        if isinstance(value, dict) and value:
            rows = f",\n{indent}  ".join(f"{line(k)}: {block(v, indent + '  ')}" for k, v in value.items())
            return f"{{\n{indent}  {rows}\n{indent}}}"
        return line(value)

    return block(data, "") + "\n"
