"""Bodies in pybullet's world, one client per engine.

Bodies are named. Static boxes stand one body each: pybullet crashes on compounds of more than 16.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pickcli.cell.hollow_body import solids_of
from pickcli.cell.item import Item
from pickcli.cell.shapes import Body, Shape, ShapeKind
from pickcli.errors import InputError
from pickcli.geometry import GRAVITY, Array, to_quaternion
from pickcli.scene.colours import Colour
from pickcli.simulation.engine_client import pybullet as p
from pickcli.simulation.engine_client import quiet

SOLVER_ITERATIONS = 50
MOST_SOLIDS = 16  # of one compound: pybullet crashes on more
STATIC_FRICTION = 0.8  # of the pod, from its published simulation model; friction of a pair is the product
ITEM_FRICTION = 0.6
ROLLING_FRICTION = 2e-4  # m, so that a rolling bottle comes to rest
STOP = 0.01  # rad or m from a joint's limit to its hard stop; a servo at the stop would rattle
GEAR_ERP = 0.2  # share of the error of coupled joints that is corrected per step
BELT_REACH = 30.0  # m that a running belt is longer at both ends, for the way that it travels
BELT_MASS, BELT_FORCE = 1000.0, 1e6  # kg, N: nothing on it slows it down
DAMPING = 0.04  # 1/s, of a free item's linear and angular velocity

# Bits of the collision groups. Probing rays hit items and firm bodies, never the robot.
DEFAULT_GROUP, STATIC_GROUP = 1, 2  # the engine's own, for movable and static bodies
ITEM_GROUP, FIRM_GROUP = 64, 128
PROBED = ITEM_GROUP | FIRM_GROUP


class EngineBodies:
    """Bodies in a physics world. ``close()`` or garbage collection frees it.

    Args:
        time_step: s per ``step()``.
    """

    def __init__(self, time_step: float) -> None:
        self.time_step = time_step
        with quiet():
            self._client = p.connect(p.DIRECT)
        self._ids: dict[str, int] = {}
        self._names: dict[int, str] = {}
        self._masses: dict[str, float] = {}  # kg, of free bodies
        self._links: dict[str, dict[str, int]] = {}  # by body: link index by name
        self._link_names: dict[str, dict[int, str]] = {}
        self._link_states: dict[tuple[str, int], tuple[Any, ...]] = {}  # cache, valid until the next change
        p.setPhysicsEngineParameter(
            fixedTimeStep=time_step,
            numSolverIterations=SOLVER_ITERATIONS,
            # Islands are solved separately, with contacts in the order of bodies, so that the accuracy does
            # not depend on distant contacts, or on memory addresses that decide which islands are merged.
            deterministicOverlappingPairs=1,
            minimumSolverIslandSize=0,
            physicsClientId=self._client,
        )
        self.accelerate((0.0, 0.0))

    def accelerate(self, acceleration: tuple[float, float]) -> None:
        """Accelerate the frame of the world over the floor: everything in it feels that as a force.

        Args:
            acceleration: m/s^2 of the frame, along its own x and y.
        """
        x, y = acceleration
        p.setGravity(-x, -y, -GRAVITY, physicsClientId=self._client)

    def close(self) -> None:
        """Free the world; it must not be used afterwards."""
        if self._client >= 0:
            p.disconnect(physicsClientId=self._client)
            self._client = -1

    def __del__(self) -> None:
        if getattr(self, "_client", -1) >= 0:
            self.close()

    def step(self) -> None:
        """Advance by one time step."""
        self._link_states.clear()
        p.stepSimulation(physicsClientId=self._client)

    # Bodies ------------------------------------------------------------------------------------------

    def add_static(self, body: Body, T_world_parent: Array, colour: Colour) -> None:
        """Add a body that never moves.

        Args:
            body: The body in its parent frame.
            T_world_parent: (4, 4) pose of that frame.
            colour: Red, green, blue and opacity.
        """
        self._create(body.name, body.shape, 0.0, T_world_parent @ body.T_parent_shape, colour)
        self._dynamics(body.name, lateralFriction=STATIC_FRICTION)
        self._group(body.name, STATIC_GROUP | FIRM_GROUP, ~STATIC_GROUP)
        # A body that is awake costs time in every step, with all sleeping bodies on it.
        self._dynamics(body.name, activationState=p.ACTIVATION_STATE_ENABLE_SLEEPING)
        self.sleep(body.name)

    def add_belt(self, body: Body, T_world_parent: Array, colour: Colour, speed: float) -> None:
        """Add a body that travels along its x axis at a constant speed and carries what stands on it.

        It is a box ``BELT_REACH`` longer at both ends, on a linear joint with a motor: items ride on it at
        exactly its speed. (Items whose velocity is set in every step lag behind by the friction of one step.)

        Args:
            body: The body in its parent frame, a box.
            T_world_parent: (4, 4) pose of that frame.
            colour: Red, green, blue and opacity.
            speed: m/s.
        """
        length, width, height = body.shape.size
        half = [length / 2 + BELT_REACH, width / 2, height / 2]
        T = T_world_parent @ body.T_parent_shape
        moving = p.createCollisionShape(p.GEOM_BOX, halfExtents=half, physicsClientId=self._client)
        seen = p.createVisualShape(
            p.GEOM_BOX, halfExtents=[length / 2, *half[1:]], rgbaColor=colour, physicsClientId=self._client
        )
        identity = to_quaternion(np.eye(3)).tolist()
        belt = p.createMultiBody(
            baseMass=0.0,
            baseVisualShapeIndex=seen,
            basePosition=T[:3, 3].tolist(),
            baseOrientation=to_quaternion(T[:3, :3]).tolist(),
            linkMasses=[BELT_MASS],
            linkCollisionShapeIndices=[moving],
            linkVisualShapeIndices=[-1],
            linkPositions=[[0.0, 0.0, 0.0]],
            linkOrientations=[identity],
            linkInertialFramePositions=[[0.0, 0.0, 0.0]],
            linkInertialFrameOrientations=[identity],
            linkParentIndices=[0],
            linkJointTypes=[p.JOINT_PRISMATIC],
            linkJointAxis=[[1.0, 0.0, 0.0]],
            physicsClientId=self._client,
        )
        self._register(body.name, belt)
        self._links[body.name], self._link_names[body.name] = {"": 0}, {0: "", -1: ""}
        self._dynamics(
            body.name, link=0, lateralFriction=STATIC_FRICTION, linearDamping=0.0, angularDamping=0.0,
            jointDamping=0.0,
        )  # fmt: skip
        p.setCollisionFilterGroupMask(
            belt, 0, STATIC_GROUP | FIRM_GROUP, ~STATIC_GROUP, physicsClientId=self._client
        )
        p.resetJointState(belt, 0, 0.0, speed, physicsClientId=self._client)
        self.drive_belt(body.name, speed)

    def drive_belt(self, name: str, speed: float) -> None:
        """Let a belt run at another speed.

        Args:
            name: Name of the body.
            speed: m/s.
        """
        p.setJointMotorControl2(
            self._ids[name], 0, p.VELOCITY_CONTROL, targetVelocity=speed, force=BELT_FORCE,
            physicsClientId=self._client,
        )  # fmt: skip

    def belt_position(self, name: str) -> float:
        """Return how far a belt has travelled.

        Args:
            name: Name of the body.

        Returns:
            m.
        """
        return float(p.getJointState(self._ids[name], 0, physicsClientId=self._client)[0])

    def set_velocity(self, name: str, velocity: Array) -> None:
        """Set the linear velocity of a free body, once.

        Args:
            name: Name of the body.
            velocity: (3,) m/s in the world.
        """
        p.resetBaseVelocity(self._ids[name], velocity.tolist(), [0.0] * 3, physicsClientId=self._client)

    def add_cubes(self, points: Array, width: float, colour: Colour) -> None:
        """Draw cubes without collision shapes.

        Args:
            points: (K, 3) m in the world, centres of the cubes.
            width: m, edge length.
            colour: Red, green, blue and opacity.
        """
        cube = p.createVisualShape(
            p.GEOM_BOX, halfExtents=[width / 2] * 3, rgbaColor=colour, physicsClientId=self._client
        )
        for point in points.tolist():
            p.createMultiBody(baseVisualShapeIndex=cube, basePosition=point, physicsClientId=self._client)

    def soften(self, name: str, stiffness: float, damping: float) -> None:
        """Make a body compliant in contacts.

        Args:
            name: Name of the body.
            stiffness: N/m.
            damping: Ns/m.
        """
        self._dynamics(name, contactStiffness=stiffness, contactDamping=damping)

    def roughen(self, name: str, link: str, friction: float) -> None:
        """Set the friction of one link; the friction of a pair is the product.

        Args:
            name: Name of the body.
            link: Name of the link.
            friction: Coefficient.
        """
        self._dynamics(name, link=self._links[name][link], lateralFriction=friction)

    def gear(self, name: str, links: tuple[str, str], ratio: float, force: float) -> None:
        """Couple the joints of two links by a gear ratio, with respect to their positions at 0.

        Args:
            name: Name of the body.
            links: Names of the child links of both joints.
            ratio: Position of the first joint over that of the second.
            force: N or Nm, largest force of the coupling.
        """
        body, (a, b) = self._ids[name], (self._links[name][link] for link in links)
        coupling = p.createConstraint(
            body, a, body, b, p.JOINT_GEAR, [1, 0, 0], [0, 0, 0], [0, 0, 0], physicsClientId=self._client
        )
        p.changeConstraint(
            coupling, gearRatio=-ratio, erp=GEAR_ERP, maxForce=force, physicsClientId=self._client
        )

    def add_item(
        self, name: str, item: Item, T_world_item: Array, colour: Colour, mass: float | None = None
    ) -> None:
        """Add a free body with the item's shape, less its hollows; it may be put to sleep by the engine.

        Args:
            name: Name of the body.
            item: The item, for shape and stated mass.
            T_world_item: (4, 4) pose.
            colour: Red, green, blue and opacity.
            mass: kg, the true mass if it differs from the stated one; distributed evenly over the shape.

        Raises:
            InputError: Its hollows divide it into more solids than the engine takes.
        """
        mass = item.mass if mass is None else mass
        if item.hollows:
            solids = solids_of(item)
            if len(solids) > MOST_SOLIDS:
                raise InputError(
                    f"item {item.name}: its hollows divide it into {len(solids)} solids, at most "
                    f"{MOST_SOLIDS} can be simulated; state fewer or larger hollows"
                )
            self._create_compound(name, solids, mass, T_world_item, colour)
        else:
            self._create(name, item.shape, mass, T_world_item, colour)
        self._masses[name] = mass
        self._dynamics(
            name,
            # pybullet's default inertia of a cylinder is that of its bounding box.
            localInertiaDiagonal=(mass * np.diag(item.shape.inertia_per_mass)).tolist(),
        )
        self._dynamics(
            name,
            lateralFriction=ITEM_FRICTION,
            rollingFriction=ROLLING_FRICTION,
            spinningFriction=ROLLING_FRICTION,
            linearDamping=DAMPING,
            angularDamping=DAMPING,
            restitution=0.0,
            activationState=p.ACTIVATION_STATE_ENABLE_SLEEPING,
        )
        self._group(name, DEFAULT_GROUP | ITEM_GROUP, -1)

    def add_solids(
        self, name: str, parts: Sequence[Body], mass: float, inertia: Array, T: Array, colour: Colour
    ) -> None:
        """Add a free body of several solids, which never sleeps.

        Args:
            name: Name of the body.
            parts: At most 16 solids in its frame, whose origin is the centre of mass.
            mass: kg.
            inertia: (3,) kg m^2, about the axes of that frame.
            T: (4, 4) its pose.
            colour: Red, green, blue and opacity.
        """
        self._create_compound(name, parts, mass, T, colour)
        self._masses[name] = mass
        self._dynamics(name, localInertiaDiagonal=inertia.tolist())
        self._dynamics(
            name, lateralFriction=ITEM_FRICTION, rollingFriction=ROLLING_FRICTION,
            spinningFriction=ROLLING_FRICTION, linearDamping=DAMPING, angularDamping=DAMPING, restitution=0.0,
        )  # fmt: skip
        self._group(name, DEFAULT_GROUP | ITEM_GROUP, -1)

    def load_robot(self, name: str, urdf: Path, T_world_base: Array) -> None:
        """Add a robot on a fixed base, without pybullet's joint damping.

        Its links collide with each other, except links connected by a joint.

        Args:
            name: Name of the body.
            urdf: File of the robot.
            T_world_base: (4, 4) pose of the root link.
        """
        with quiet():
            body = p.loadURDF(
                str(urdf),
                basePosition=T_world_base[:3, 3].tolist(),
                baseOrientation=to_quaternion(T_world_base[:3, :3]).tolist(),
                useFixedBase=True,
                flags=p.URDF_USE_SELF_COLLISION
                | p.URDF_USE_SELF_COLLISION_EXCLUDE_PARENT
                | p.URDF_USE_INERTIA_FROM_FILE,
                physicsClientId=self._client,
            )
        self._register(name, body)
        for index in range(p.getNumJoints(body, physicsClientId=self._client)):
            info = p.getJointInfo(body, index, physicsClientId=self._client)
            link = info[12].decode()
            self._links[name][link] = index
            self._link_names[name][index] = link
            self._dynamics(name, link=index, linearDamping=0.0, angularDamping=0.0, jointDamping=0.0)
            if info[2] in (p.JOINT_REVOLUTE, p.JOINT_PRISMATIC):
                self._dynamics(
                    name, link=index, jointLowerLimit=info[8] - STOP, jointUpperLimit=info[9] + STOP
                )
        root = p.getBodyInfo(body, physicsClientId=self._client)[0].decode()
        self._links[name][root] = -1
        self._link_names[name][-1] = root

    def remove(self, name: str) -> None:
        """Remove a body from the world.

        Args:
            name: Name of the body.
        """
        self._link_states.clear()
        p.removeBody(self._ids[name], physicsClientId=self._client)
        del self._names[self._ids.pop(name)]

    def _create(self, name: str, shape: Shape, mass: float, T: Array, colour: Colour) -> None:
        collision = p.createCollisionShape(physicsClientId=self._client, **_shape_arguments(shape, "height"))
        visual = p.createVisualShape(
            physicsClientId=self._client, rgbaColor=colour, **_shape_arguments(shape, "length")
        )
        body = p.createMultiBody(
            baseMass=mass,
            baseCollisionShapeIndex=collision,
            baseVisualShapeIndex=visual,
            basePosition=T[:3, 3].tolist(),
            baseOrientation=to_quaternion(T[:3, :3]).tolist(),
            physicsClientId=self._client,
        )
        self._register(name, body)

    def _create_compound(
        self, name: str, parts: Sequence[Body], mass: float, T: Array, colour: Colour
    ) -> None:
        solids = [_shape_arguments(part.shape, "length") for part in parts]
        arguments = {
            "shapeTypes": [each["shapeType"] for each in solids],
            "halfExtents": [each.get("halfExtents", [1.0] * 3) for each in solids],
            "radii": [each.get("radius", 1.0) for each in solids],
            "lengths": [each.get("length", 1.0) for each in solids],
        }
        at = [part.T_parent_shape[:3, 3].tolist() for part in parts]
        turns = [to_quaternion(part.T_parent_shape[:3, :3]).tolist() for part in parts]
        body = p.createMultiBody(
            baseMass=mass,
            baseCollisionShapeIndex=p.createCollisionShapeArray(
                **arguments, collisionFramePositions=at, collisionFrameOrientations=turns,
                physicsClientId=self._client,
            ),
            baseVisualShapeIndex=p.createVisualShapeArray(
                **arguments, rgbaColors=[colour] * len(solids), visualFramePositions=at,
                visualFrameOrientations=turns, physicsClientId=self._client,
            ),
            basePosition=T[:3, 3].tolist(),
            baseOrientation=to_quaternion(T[:3, :3]).tolist(),
            physicsClientId=self._client,
        )  # fmt: skip
        self._register(name, body)

    def _register(self, name: str, body: int) -> None:
        self._ids[name], self._names[body] = body, name
        self._links[name], self._link_names[name] = {"": -1}, {-1: ""}

    def _group(self, name: str, group: int, mask: int) -> None:
        p.setCollisionFilterGroupMask(self._ids[name], -1, group, mask, physicsClientId=self._client)

    def _dynamics(self, name: str, link: int = -1, **values: object) -> None:
        p.changeDynamics(self._ids[name], link, physicsClientId=self._client, **values)

    def has_body(self, name: str) -> bool:
        """Whether a body is in the world.

        Args:
            name: Name of the body.

        Returns:
            True if it is.
        """
        return name in self._ids

    def has_link(self, name: str, link: str) -> bool:
        """Whether a body has a link.

        Args:
            name: Name of the body.
            link: Name of the link.

        Returns:
            True if it has.
        """
        return link in self._links[name]

    def set_collision(self, a: str, link_a: str, b: str, link_b: str, on: bool) -> None:
        """Set whether two parts collide in the physics.

        The engine removes both parts from its broad phase and adds them again as the newest. It forgets their
        contacts, which what stands on a round base gets back one by one, and the order and orientation in
        which contacts are solved change. Callers that switch several pairs must use a fixed order: the
        iteration order of a set of names differs between processes.

        Args:
            a: Name of one body.
            link_a: Name of its link.
            b: Name of the other body.
            link_b: Name of its link.
            on: Whether they collide.
        """
        p.setCollisionFilterPair(
            self._ids[a], self._ids[b], self._links[a][link_a], self._links[b][link_b], int(on),
            physicsClientId=self._client,
        )  # fmt: skip

    def wake(self, name: str) -> None:
        """Wake a sleeping body; creating a constraint does not wake it.

        Args:
            name: Name of the body.
        """
        self._dynamics(name, activationState=p.ACTIVATION_STATE_WAKE_UP)

    def sleep(self, name: str) -> None:
        """Let a body sleep until something that moves touches it.

        Args:
            name: Name of the body.
        """
        self._dynamics(name, activationState=p.ACTIVATION_STATE_SLEEP)

    def fix(self, name: str) -> None:
        """Fix a free body permanently at its current pose.

        Args:
            name: Name of the body.
        """
        p.resetBaseVelocity(self._ids[name], [0.0] * 3, [0.0] * 3, physicsClientId=self._client)
        self._dynamics(name, mass=0.0)

    def keep_awake(self, name: str, on: bool) -> None:
        """Set whether a free body must stay awake, such as a held item. It wakes up in either case.

        Args:
            name: Name of the body.
            on: Whether it must stay awake.
        """
        state = p.ACTIVATION_STATE_DISABLE_SLEEPING if on else p.ACTIVATION_STATE_ENABLE_SLEEPING
        self._dynamics(name, activationState=state)
        self.wake(name)

    def is_free(self, name: str) -> bool:
        """Whether a body moves freely.

        Args:
            name: Name of the body.

        Returns:
            True for items and other solids that nothing holds.
        """
        return name in self._masses

    def mass(self, name: str) -> float:
        """Return the true mass of a free body.

        Args:
            name: Name of the body.

        Returns:
            kg.
        """
        return self._masses[name]


def _shape_arguments(shape: Shape, length_name: str) -> dict[str, object]:
    """Keyword arguments of pybullet for a shape; it has two names for a cylinder's length."""
    if shape.kind is ShapeKind.BOX:
        return {"shapeType": p.GEOM_BOX, "halfExtents": [s / 2 for s in shape.size]}
    if shape.kind is ShapeKind.CYLINDER:
        return {"shapeType": p.GEOM_CYLINDER, "radius": shape.size[0], length_name: shape.size[1]}
    return {"shapeType": p.GEOM_SPHERE, "radius": shape.size[0]}
