"""A cell with all its arms: one arm moves at a time, the others are stationary obstacles."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

from pickcli.cell.cell import ArmState, Cell
from pickcli.cell.fingerprint import digest, equipment, fingerprint
from pickcli.cell.robot import Robot
from pickcli.cell.robots.planning_group import planning_group
from pickcli.cell.robots.urdf import Urdf
from pickcli.errors import InputError, UnknownNameError


@dataclass(frozen=True)
class Parking:
    """Parking configuration and preference of an arm.

    Attributes:
        arm: Name of the arm.
        parked: Name of the configuration in which it stands while another arm moves.
        preference: Among the arms suitable for a task, the one with the least value is chosen.
    """

    arm: str
    parked: str
    preference: int


@dataclass(frozen=True, eq=False)
class Workcell:
    """A cell with all its arms.

    Planner, verifier and stored files handle one arm each: they use the cell of that arm, in which the other
    arms are links that no joint moves. The joint positions of the others are part of its fingerprint. Arms
    with the same joints are tools on one flange: the links of the other tool move along.

    Attributes:
        arms: The cell of every arm by name, all others parked, the preferred arm first; a single arm has the
            name "".
        parked: Parked state of each arm by name; empty with a single arm.
        preferences: Preference by name of the arm.
        tree: The robot with all tools.
        posture: Positions in rad or m of the joints that belong to no arm.
    """

    arms: dict[str, Cell]
    parked: dict[str, ArmState]
    preferences: dict[str, int]
    tree: Urdf
    posture: Mapping[str, float]

    @classmethod
    def of(
        cls, cells: Mapping[str, Cell], arms: Sequence[Parking], tree: Urdf, posture: Mapping[str, float]
    ) -> Workcell:
        """Combine the cells of several arms.

        Args:
            cells: By arm, each with the other arms parked, without fingerprints.
            arms: Parking of each arm; empty for a cell with one arm.
            tree: The robot with all tools.
            posture: Positions in rad or m of the joints that belong to no arm.

        Returns:
            The workcell.
        """
        parked = {arm.arm: _state_in(cells[arm.arm], arm) for arm in arms}
        preferences = {arm.arm: arm.preference for arm in arms}
        named = {
            name: _beside(
                replace(cell, arm=name),
                tuple(state for other, state in parked.items() if other != name),
                cells, tree, posture,
            )
            for name, cell in sorted(cells.items(), key=lambda entry: preferences.get(entry[0], 0))
        }  # fmt: skip
        prints = {name: fingerprint(cell) for name, cell in named.items()}
        whole, others = digest(prints) if arms else "", equipment(named.values())
        known = {
            name: replace(cell, fingerprint=prints[name], parked_fingerprint=whole, equipment=others)
            for name, cell in named.items()
        }
        return cls(known, parked, preferences, tree, posture)

    @property
    def name(self) -> str:
        """Name of the cell."""
        return self.preferred.name

    @property
    def preferred(self) -> Cell:
        """The cell as seen by the preferred arm."""
        return next(iter(self.arms.values()))

    @property
    def moving_joints(self) -> tuple[str, ...]:
        """Names of all joints that move, each once: the planned ones of every arm, then those of its tool."""
        return tuple(dict.fromkeys(name for cell in self.arms.values() for name in cell.robot.moving_joints))

    @property
    def robot(self) -> Robot:
        """The robot of the preferred arm, in which the joints of all other arms move as well."""
        robot = self.preferred.robot
        links, joints = planning_group(self.tree, robot.tool.last_link, self.moving_joints, self.posture)
        return replace(robot, links=links, joints=joints)

    def cell(self, arm: str | None = None, standing: Iterable[ArmState] = ()) -> Cell:
        """Return the cell as seen by one arm.

        Args:
            arm: Name of the arm; None if the cell has only one.
            standing: States of other arms; arms not listed are parked.

        Returns:
            The cell.

        Raises:
            InputError: The cell has several arms and none is named, or it has one and a name is given; or
                ``standing`` lists the arm itself.
            UnknownNameError: There is no such arm.
        """
        name = self.known(arm)
        stated = {self.known(state.arm): state for state in standing}
        if name in stated:
            raise InputError(f"arm {name}: is the one that moves; say only where other arms stand")
        cell = self.arms[name]
        if not stated:
            return cell
        others = tuple(stated.get(state.arm, state) for state in cell.others)
        moved = _beside(cell, others, self.arms, self.tree, self.posture)
        return replace(moved, fingerprint=fingerprint(moved))

    def known(self, arm: str | None) -> str:
        """Return the key of an arm in ``arms``.

        Args:
            arm: Name of the arm; None if the cell has only one.

        Returns:
            Its name; "" for a single arm.

        Raises:
            InputError: The cell has several arms and none is named, or it has one and a name is given.
            UnknownNameError: There is no such arm.
        """
        names = [name for name in self.arms if name]
        if arm is None:
            if names:
                raise InputError(
                    f"cell {self.name}: has the arms {' and '.join(names)}; say which with --arm NAME"
                )
            return ""
        if not names:
            raise InputError(f"cell {self.name}: has one arm, which needs no name; leave out {arm!r}")
        if arm not in names:
            raise UnknownNameError("arm", arm, names)
        return arm


def _state_in(cell: Cell, arm: Parking) -> ArmState:
    named = cell.configurations[arm.parked]
    return ArmState(arm.arm, named.q, named.tool_state)


def _beside(
    cell: Cell, others: tuple[ArmState, ...], cells: Mapping[str, Cell], tree: Urdf, rest: Mapping[str, float]
) -> Cell:
    """The cell of an arm with the others in the given states; its fingerprint is left unchanged."""
    if not others:
        return cell
    posture = dict(rest)
    for state in others:
        own = cells[state.arm].robot
        # Joints that the arms share are among ``moving``, which the posture does not fix.
        posture |= dict(zip(own.joint_names, state.q.tolist(), strict=True))
        posture |= {joint: own.tool.joint_position(joint, state.tool_state) for joint in own.tool.joints}
    links, joints = planning_group(tree, cell.robot.tool.last_link, cell.robot.moving_joints, posture)
    return replace(cell, robot=replace(cell.robot, links=links, joints=joints), others=others)
