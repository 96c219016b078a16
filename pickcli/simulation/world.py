"""Simulated world of a scene: cell, robot and items in one physics engine, stepped together.

After the start the robot moves only by its motors. Randomness (``Reality``) depends only on the seed: two new
worlds of the same scene and seed, with the same commands, are bit-identical.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.device import DeviceKind
from pickcli.cell.tool import ToolState
from pickcli.geometry import GRAVITY, Array
from pickcli.scene.colours import static_colour
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.simulation.collision_filter import CollisionFilter
from pickcli.simulation.contacts import Collision, ContactLog
from pickcli.simulation.driver import device_for
from pickcli.simulation.engine import Engine
from pickcli.simulation.engine_bodies import BELT_REACH
from pickcli.simulation.fingers import Fingers
from pickcli.simulation.grip import Grip
from pickcli.simulation.places import location_of
from pickcli.simulation.planned_contacts import PlannedContacts
from pickcli.simulation.reality import DEFAULT, Reality
from pickcli.simulation.robot_urdf import write_urdf
from pickcli.simulation.running_belt import RunningBelt
from pickcli.simulation.scene_bodies import (
    add_items,
    add_statics,
    ground_of,
    is_over,
    true_masses,
)
from pickcli.simulation.servo import IDEAL, Drives, Servo
from pickcli.simulation.suction import Suction
from pickcli.simulation.tool_choice import simulated_tool

TIME_STEP = 1e-3  # s: 2 mm of tool motion at 2 m/s, the accuracy of events; takes 75 us to compute
ROBOT = "robot"
REST_STEPS = 100  # steps between checks for items at rest
REST_MOVE = 2e-4  # m
REST_SPEED = 5e-3  # m/s
REST_TURN_RATE = 0.01  # rad/s
REST_LOOKS = 2  # consecutive checks at rest before an item sleeps: toppling begins slowly


class World:
    """Cell, robot and items of a scene, at rest at simulated time 0.

    Attributes:
        planned: Contacts allowed at present; initially none.
        tool: The simulated tool.
        belts: The conveyors that run, by name.

    Args:
        scene: The scene, with true item poses; noise is added by the planner's perception.
        q: (n,) initial configuration.
        tool_state: Initial state of the tool, its default state if None.
        reality: Deviations of this world from the planner's model.
        seed: Seed of all random deviations.
        servo: Parameters of joint following; by default as in ``reality``.
        time_step: s.
    """

    def __init__(
        self,
        scene: Scene,
        q: Array,
        tool_state: ToolState | None = None,
        *,
        reality: Reality = DEFAULT,
        seed: int = 0,
        servo: Servo | None = None,
        time_step: float = TIME_STEP,
    ) -> None:
        self.scene, self.time_step = scene, time_step
        self.reality, self.seed = reality, seed
        self._item_seed = seed
        self._n_steps = 0
        self.servo = servo or (Servo() if reality.servo else IDEAL)
        self.planned = PlannedContacts()
        self.observer: Callable[[World], None] | None = None  # called after every step; read-only
        self.robot = scene.cell.robot
        self.engine = Engine(time_step)
        self._model = Engine(time_step)  # only the robot, for its inverse dynamics
        add_statics(self.engine, scene)
        add_items(self.engine, scene, true_masses(scene, reality, seed))
        self._positions = {placed.id: placed.T_world_item[:3, 3] for placed in scene.items}
        self._looks_at_rest = {placed.id: 0 for placed in scene.items}
        self.belts: dict[str, RunningBelt] = {}
        self._ground = ground_of(scene)
        self._mount(q, tool_state or self.robot.tool.default_state)

    def reseed(self, seed: int) -> None:
        """Draw what happens from now on by another seed; what the items truly are stays.

        Worlds that follow one another with the same items begin with one seed, and go on with their own.

        Args:
            seed: The seed.
        """
        self.seed = seed

    def run_belt(self, name: str, speed: float) -> None:
        """Let a conveyor that stood run at a constant speed, and its items come along at that speed.

        Args:
            name: Name of the conveyor.
            speed: m/s along its +x.
        """
        carrier = next(each for each in self.scene.posed_carriers if each.name == name)
        (body,) = carrier.bodies
        self.engine.remove(body.name)
        self.engine.add_belt(body, carrier.T_world_carrier, static_colour(name), speed)
        conveyor = self.scene.cell.carriers[name].conveyor
        assert conveyor is not None
        self.belts[name] = RunningBelt(self.engine, body.name, conveyor, speed)
        way = BELT_REACH * np.abs(carrier.T_world_carrier[:3, 0])
        self._ground = self._ground[0] - way, self._ground[1] + way
        for placed in self.scene.items:
            if placed.location in self.scene.cell.carriers[name].places:
                self.engine.set_velocity(placed.id, speed * carrier.T_world_carrier[:3, 0])

    def belt_travel(self, conveyor: str) -> float | None:
        """Return the reading of the encoder of a conveyor.

        Args:
            conveyor: Name of the conveyor.

        Returns:
            m since the belt began to run; None if it stands.
        """
        return self.belts[conveyor].travel if conveyor in self.belts else None

    def encoder_latency(self, conveyor: str) -> float:
        """Return by how much a reading of the encoder of a conveyor is old.

        Args:
            conveyor: Name of the conveyor.

        Returns:
            s.
        """
        figures = self.scene.cell.carriers[conveyor].conveyor
        assert figures is not None
        return figures.encoder_latency

    def close(self) -> None:
        """Free the engines."""
        self.engine.close()
        self._model.close()

    def let_move(self, cell: Cell, q: Array, tool_state: ToolState) -> None:
        """Switch to another arm of the robot; all others are stationary where its cell has them.

        Time, items and the log of contacts continue.

        Args:
            cell: The cell as seen by that arm.
            q: (n,) its configuration.
            tool_state: State of its tool.
        """
        self.scene, self.robot = replace(self.scene, cell=cell), cell.robot
        self._remount(q, tool_state)

    def bring_in(self, placed: PlacedItem) -> None:
        """Add an item that comes into the cell, at rest, while the arm is at rest and holds nothing.

        Time, other items and the log of contacts continue; the valve is closed.

        Args:
            placed: The item, of an id that no item of the scene has.
        """
        self.scene = replace(self.scene, items=(*self.scene.items, placed))
        alone = replace(self.scene, items=(placed,))
        add_items(self.engine, alone, true_masses(alone, self.reality, self._item_seed))
        self._positions[placed.id], self._looks_at_rest[placed.id] = placed.T_world_item[:3, 3], 0
        self._remount(self.q.copy(), self.tool_state)

    def take_out(self, item_id: str) -> None:
        """Take an item out of the world, as by hand, while the arm is at rest and does not hold it.

        Args:
            item_id: Id of the item.
        """
        self.scene = replace(self.scene, items=tuple(p for p in self.scene.items if p.id != item_id))
        self.engine.remove(item_id)
        del self._positions[item_id], self._looks_at_rest[item_id]
        self._remount(self.q.copy(), self.tool_state)

    def _remount(self, q: Array, tool_state: ToolState) -> None:
        """Replace the robot, and all that knows its links and the items."""
        self.engine.remove(ROBOT)
        # pybullet keeps inverse dynamics by a body's address, also for the next body at that address.
        self._model.close()
        self._model = Engine(self.time_step)
        self._mount(q, tool_state, self.contacts.collisions)

    def _mount(self, q: Array, tool_state: ToolState, earlier: tuple[Collision, ...] = ()) -> None:
        """Add the robot with tool, collision filter and contact log. earlier: logged collisions."""
        self.tool = simulated_tool(self.scene.cell, self.reality, self.servo.lag, tool_state)
        self._load_robot(q, tool_state)
        self._filter = CollisionFilter(self.engine, ROBOT, self.scene)
        self.tool.mount(self.engine, ROBOT, {placed.id: placed.item for placed in self.scene.items})
        links = self.robot.tool.contact_links
        self.contacts = ContactLog(ROBOT, links, self._filter.exempt, self.tool.max_press, earlier)

    def _load_robot(self, q: Array, tool_state: ToolState) -> None:
        tool = self.robot.tool
        with TemporaryDirectory() as folder:
            urdf = write_urdf(self.robot, Path(folder))
            for engine in (self.engine, self._model):
                engine.load_robot(ROBOT, urdf, self.robot.T_world_base)
        indices = self.engine.joints(ROBOT)
        names, forces = self.robot.joint_names, self.robot.motor_forces
        self._drives = Drives(
            self.servo, names, self.robot.limits, np.array([forces[name] for name in names]), self.time_step
        )
        self._forces = self._drives.forces.tolist()  # largest efforts of all motors, N or Nm
        if self.tool.drive is not None:
            self._forces += self.tool.drive.forces.tolist()
        tool_joints = tool.joints
        start = np.array([*q, *(tool.joint_position(name, tool_state) for name in tool_joints)])
        self._n_joints = self.robot.n_joints
        self._indices = [indices[name] for name in (*names, *tool_joints)]
        self.engine.reset_joints(ROBOT, dict(zip(self._indices, start.tolist(), strict=True)))
        self._command = np.array(q, dtype=float)
        self._measured = start
        self._torques = np.zeros(len(start))
        self._tip: Array | None = None  # computed on demand, once per step

    # Commands ----------------------------------------------------------------------------------------

    def command(self, q: Array) -> None:
        """Set the target of the servo at the end of the next step, valid until the next one.

        Args:
            q: (n,) configuration.
        """
        self._command = np.array(q, dtype=float)

    def act(self, device: str, action: str) -> bool | None:
        """Switch a device.

        Args:
            device: Name of the device.
            action: One of its actions.

        Returns:
            A sensor's reading, whether an item is held; None for other devices.

        Raises:
            UnknownNameError: There is no such device or action.
        """
        kind = device_for(self.cell, device, action).kind
        if kind is DeviceKind.SENSOR:
            return self.grip.is_holding
        if kind is DeviceKind.PUMP:
            self.suction.vacuum.switch_pump(action == "on")
        elif kind is DeviceKind.VALVE:
            self.suction.vacuum.switch_valve(action == "on")
        elif self.tool.drive is not None:
            self.tool.drive.command(self.robot.tool.position(ToolState(action)))
        return None

    def step(self) -> None:
        """Advance by one time step: servo, grip, physics, contacts."""
        self.grip.before_step(self.tip)
        self._filter.let_through(self.grip)
        self._drive()
        for belt in self.belts.values():
            belt.before_step()
        self.engine.step()
        for belt in self.belts.values():
            belt.after_step()
        self._n_steps += 1
        self._measured, self._torques = self.engine.joint_states(ROBOT, self._indices)
        self._tip = None
        if self._n_steps % REST_STEPS == 0:
            self._look_at_items()
        self._look_at_contacts()
        self.grip.after_step(self.t)
        if self.observer is not None:
            self.observer(self)

    def _drive(self) -> None:
        """Set the motors for the next step, of the planned joints and of the tool."""
        velocities = self._drives.velocities(self._command, self.q, self.torques).tolist()
        if (tool := self.tool.drive) is not None:
            velocities += tool.velocities(self._measured[self._n_joints :], self.time_step).tolist()
        self.engine.drive(ROBOT, self._indices, velocities, self._forces)

    def wait(self, duration: float, on_step: Callable[[World], None] | None = None) -> None:
        """Hold the last command for a while.

        Args:
            duration: s.
            on_step: Called after every time step.
        """
        for _ in range(round(duration / self.time_step)):
            self.step()
            if on_step is not None:
                on_step(self)

    def _look_at_contacts(self) -> None:
        points = self.engine.contact_points(ROBOT)
        # The relaxed bellows push off a released item; that is no new contact.
        points += [point for point in self.grip.contact_points if point.b not in self._filter.let_go_through]
        if self.held is not None and not self.planned.is_meeting:
            points += self.engine.contact_points(self.held)
        weight = 0.0 if self.held is None else GRAVITY * self.engine.mass(self.held)
        self.contacts.update(points, self.planned, self.held, self.t, weight)

    def _look_at_items(self) -> None:
        """Put items at rest to sleep, as each awake one costs 50 us per step; fix items that fell off.

        The engine alone puts them to sleep only after 2 s without jitter.
        """
        for placed in self.scene.items:
            position = self.engine.pose(placed.id)[:3, 3]
            moved = float(np.abs(position - self._positions[placed.id]).max())
            self._positions[placed.id] = position
            linear, angular = self.engine.speed(placed.id)
            rests = moved < REST_MOVE and linear < REST_SPEED and angular < REST_TURN_RATE
            self._looks_at_rest[placed.id] = self._looks_at_rest[placed.id] + 1 if rests else 0
            if placed.id == self.held:
                continue
            if not is_over(self._ground, position):
                self.engine.fix(placed.id)
            elif self._looks_at_rest[placed.id] >= REST_LOOKS:
                self.engine.sleep(placed.id)

    # State -------------------------------------------------------------------------------------------

    @property
    def cell(self) -> Cell:
        """The cell as seen by the moving arm."""
        return self.scene.cell

    @property
    def t(self) -> float:
        """Simulated time, s."""
        return self._n_steps * self.time_step

    @property
    def q(self) -> Array:
        """Measured configuration (n,)."""
        return self._measured[: self._n_joints]

    @property
    def joints(self) -> Array:
        """Measured positions (m,) of the planned joints, followed by those of the tool's joints."""
        return self._measured

    def inverse_dynamics(self, joints: Array, dq: Array, ddq: Array) -> Array:
        """Compute the motor torques of a motion of all joints by the robot's model, without payload.

        Args:
            joints: (m,) positions.
            dq: (m,) velocities.
            ddq: (m,) accelerations.

        Returns:
            (m,) Nm or N.
        """
        return self._model.inverse_dynamics(ROBOT, joints, dq, ddq)

    @property
    def torques(self) -> Array:
        """Motor efforts (n,) of the planned joints in the last step, N or Nm."""
        return self._torques[: self._n_joints]

    @property
    def tool_state(self) -> ToolState:
        """Present state of the tool."""
        return self.tool.state(self._measured[self._n_joints :])

    @property
    def grip(self) -> Grip:
        """The grip that holds items."""
        return self.tool.grip

    @property
    def tip(self) -> Array:
        """``T_world_tip`` (4, 4), measured, including the tool's joint."""
        if self._tip is None:
            tool = self.robot.tool
            self._tip = self.engine.pose(ROBOT, tool.last_link) @ tool.T_last_tip
        return self._tip

    @property
    def held(self) -> str | None:
        """Id of the item held by cup or fingers."""
        return self.grip.held

    @property
    def suction(self) -> Suction:
        """The suction of the cup. Raises InputError without a cup."""
        return self.tool.suction

    @property
    def fingers(self) -> Fingers | None:
        """The simulated fingers; None without fingers."""
        return self.tool.fingers

    def placed(self, item_id: str) -> PlacedItem:
        """Return an item at its present pose, with its present location.

        Args:
            item_id: Id of the item.

        Returns:
            The item, in the place where it is now.
        """
        before = self.scene.find(item_id)
        T = self.engine.pose(item_id)
        return replace(before, T_world_item=T, location=location_of(self.scene, before.item, T))

    def now(self) -> Scene:
        """Return the scene at present, without the held item."""
        items = tuple(self.placed(p.id) for p in self.scene.items if p.id != self.held)
        return replace(self.scene, items=items)
