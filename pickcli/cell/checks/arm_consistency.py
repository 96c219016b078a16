"""Consistency of cell files with several arms: owners of joints, configurations and devices."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, fields, replace

from pickcli.cell.checks.consistency import check_consistency
from pickcli.cell.checks.gripper_consistency import check_stroke, finger_joint
from pickcli.cell.checks.references import refer
from pickcli.cell.item import Item
from pickcli.cell.robots.robot_tree import WORLD
from pickcli.cell.robots.urdf import Urdf
from pickcli.cell.schemas.cell_schema import CellModel
from pickcli.cell.schemas.tool_schema import GripperModel, SuctionModel
from pickcli.errors import InputError
from pickcli.files.source import Key, Source


@dataclass
class ArmSource(Source):
    """A cell file as seen by one of its arms; mistakes are reported at the arm's position in the file.

    Attributes:
        arm: Name of the arm.
        configurations: Indices of the arm's configurations in the file's list.
        elsewhere: Joints of other arms. Mistakes in their posture are ignored here.
    """

    arm: str = ""
    configurations: tuple[int, ...] = ()
    elsewhere: frozenset[str] = frozenset()

    def add(self, key: Key, text: str) -> None:
        """Note a mistake.

        Args:
            key: Key of the value in the file of a cell with only this arm.
            text: What is wrong and what to do about it.
        """
        if key[:2] == ("robot", "posture") and key[-1] in self.elsewhere:
            return
        super().add(self.stated(key), text)

    def stated(self, key: Key) -> Key:
        """Map a key of the single-arm view to the key in the file.

        Args:
            key: Key of the value in the file of a cell with only this arm.

        Returns:
            Its key in the file.
        """
        if key[:2] in (("robot", "joints"), ("robot", "tip")):
            return ("arms", self.arm, *key[1:])
        if key[:1] == ("tool",):
            return ("arms", self.arm, *key)
        if key[:1] == ("configurations",) and len(key) > 1 and isinstance(key[1], int):
            return ("configurations", self.configurations[key[1]], *key[2:])
        return key


def check_arms(source: Source, model: CellModel) -> None:
    """Check that each joint and each configuration belongs to one arm, and that each arm can park.

    Args:
        source: Collects the mistakes with their places in the file.
        model: The cell as it stands in the file.

    Raises:
        InputError: With every mistake.
    """
    _check_robots(source, model)
    if model.arms:
        _check_one_owner(source, model)
        for name, arm in model.arms.items():
            own = [c.name for c in model.configurations if c.arm == name]
            refer(source, ("arms", name, "parked"), f"configuration of arm {name}", arm.parked, own)
        _check_same_parking(source, model)
    elif not model.robots and not model.robot.joints:
        text = "expected the planned joints, base outwards, got nothing; add it, or arms"
        source.add(("robot", "joints"), text)
    for key, owner in _owners(model):
        if owner is not None and not model.arms:
            source.add(key, "the cell has one arm, which needs no name; leave it out")
        elif owner is not None:
            refer(source, key, "arm", owner, list(model.arms))
        elif model.arms and key[0] == "configurations":
            source.add(key, f"expected the arm that it is of ({', '.join(model.arms)}), got nothing; add it")
    source.check()


def check_each_arm(source: Source, model: CellModel, robot: Urdf, items: Collection[Item]) -> None:
    """Check the consistency of a cell file for each of its arms.

    Args:
        source: The file, for places in messages.
        model: The cell as it stands in the file.
        robot: The robot with all tools.
        items: The known items.

    Raises:
        InputError: With every disagreement.
    """
    for name in model.arms:
        others = frozenset(_posture_of_others(model, name, robot))
        seen = replace(source_of_arm(source, name), elsewhere=others)
        with suppress(InputError):  # mistakes of the other arms are reported too
            alone = model_of_arm(model, name, robot)
            check_consistency(seen, alone, robot)
            check_stroke(seen, alone, items)
        source.problems += seen.problems
    source.check()


def source_of_arm(source: Source, arm: str) -> ArmSource:
    """Return a cell file as seen by one of its arms, without mistakes so far.

    Args:
        source: The file.
        arm: Name of the arm.

    Returns:
        The same values with the same places.
    """
    known = {field.name: getattr(source, field.name) for field in fields(Source)}
    own = tuple(i for i, c in enumerate(source.data["configurations"]) if c.get("arm") == arm)
    return ArmSource(**known | {"problems": []}, arm=arm, configurations=own)


def model_of_arm(model: CellModel, name: str, robot: Urdf) -> CellModel:
    """Return the model of a cell file with only one of its arms.

    Args:
        model: The cell as it stands in the file.
        name: Name of the arm.
        robot: The robot with all tools.

    Returns:
        The cell without ``arms``. The joints of other arms are in ``robot.posture``, all at 0, because the
        parked positions may change.
    """
    arm, others = model.arms[name], _posture_of_others(model, name, robot)
    robot_of_arm = model.robot.model_copy(
        update={
            "joints": arm.joints,
            "tip": arm.tip,
            "posture": {**model.robot.posture, **others},
            "motor_forces": {j: f for j, f in model.robot.motor_forces.items() if j not in others},
        }
    )
    return model.model_copy(
        update={
            "robot": robot_of_arm,
            "arms": {},
            "tool": arm.tool,
            "joint_limits": {j: limit for j, limit in model.joint_limits.items() if j not in others},
            "configurations": tuple(c for c in model.configurations if c.arm == name),
            "devices": {n: device for n, device in model.devices.items() if device.arm in (None, name)},
        }
    )


def _posture_of_others(model: CellModel, name: str, robot: Urdf) -> dict[str, float]:
    """Positions 0 for the joints of all other arms and of their tools."""
    found = [
        joint
        for other, arm in model.arms.items()
        if other != name
        for joint in (*arm.joints, *_joints_of_tool(arm.tool, robot))
    ]
    return dict.fromkeys((joint for joint in found if joint not in model.arms[name].joints), 0.0)


def _joints_of_tool(tool: SuctionModel | GripperModel | None, robot: Urdf) -> tuple[str, ...]:
    if isinstance(tool, GripperModel):
        return tuple(finger_joint(robot, link).name for link in tool.fingers)
    return () if tool is None or tool.joint is None else (tool.joint,)


def _check_one_owner(source: Source, model: CellModel) -> None:
    """Check that per-arm values are stated under ``arms`` and that no joint has two owners."""
    for key, is_stated in (
        (("robot", "joints"), bool(model.robot.joints)),
        (("robot", "tip"), model.robot.tip is not None),
        (("tool",), model.tool is not None),
    ):
        if is_stated:
            source.add(key, "is of a cell with one arm; state it under arms, for each of them")
    owners: dict[str, str] = {}
    for name, arm in model.arms.items():
        for joint in arm.joints:
            owner = owners.setdefault(joint, name)
            if owner != name and arm.joints != model.arms[owner].joints:
                text = (
                    f"{joint!r} is a joint of arm {owner} too; leave it out, or list the same joints in the "
                    "same order for two tools on one flange"
                )
                source.add(("arms", name, "joints"), text)
    for joint in model.robot.posture.keys() & owners.keys():
        text = f"is a joint of arm {owners[joint]}; its configurations say where it stands: leave it out"
        source.add(("robot", "posture", joint), text)


def _check_same_parking(source: Source, model: CellModel) -> None:
    """Check that tools on one flange park at the same joint positions, where they take turns."""
    parked = {
        name: tuple(c.q)
        for name, arm in model.arms.items()
        for c in model.configurations
        if (c.arm, c.name) == (name, arm.parked)
    }
    first: dict[tuple[str, ...], str] = {}
    for name in parked:
        other = first.setdefault(tuple(model.arms[name].joints), name)
        if parked[name] != parked[other]:
            text = f"is on the joints of {other}, which is parked at other positions; give both the same q"
            source.add(("arms", name, "parked"), text)


def _check_robots(source: Source, model: CellModel) -> None:
    """Check that a single robot is stated under robot, and several under robots with arms."""
    own = {"urdf": model.robot.urdf, "T_world_base": model.robot.T_world_base, "srdf": model.robot.srdf}
    for key, value in own.items():
        if model.robots and value is not None:
            source.add(("robot", key), "is of a cell with one robot; state it under robots, for each of them")
        elif not model.robots and value is None and key != "srdf":
            what = "the URDF's path" if key == "urdf" else "where the root link stands"
            source.add(("robot", key), f"expected {what}, got nothing; add it, or robots")
    if model.robots and not model.arms:
        source.add(("robots",), "the joints of several robots are those of several arms; add arms")


def check_side_by_side(source: Source, robots: Mapping[str, Urdf]) -> None:
    """Check that link and joint names are unique among the robots of a cell.

    Args:
        source: The file, for places in messages.
        robots: The robots by name, with their links and joints prefixed.

    Raises:
        InputError: With every robot that shares a name with another one.
    """
    owners: dict[str, str] = {f"link {WORLD!r}": "the cell"}
    for name, robot in robots.items():
        names = [f"link {link!r}" for link in robot.links]
        names += [f"joint {joint.name!r}" for joint in robot.joints.values()]
        twice = next((each for each in names if each in owners), None)
        if twice is not None:
            text = f"{twice} is one of {owners[twice]} too; give it a prefix"
            source.add(("robots", name), text)
        owners |= dict.fromkeys(names, f"robot {name}")
    source.check()


def _owners(model: CellModel) -> Iterator[tuple[Key, str | None]]:
    """Yield the owner arm, if stated, of everything that may have one, with its key in the file."""
    for i, configuration in enumerate(model.configurations):
        yield ("configurations", i, "arm"), configuration.arm
    for name, device in model.devices.items():
        yield ("devices", name, "arm"), device.arm
