"""The only file that talks to pybullet: one client of its own per engine, poses as (4, 4) arrays.

Bodies are named. Static boxes stand one body each: pybullet crashes on compounds of more than 16.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray

from pickcli.cell.item import Item
from pickcli.cell.shapes import Body, Shape, ShapeKind
from pickcli.geometry import Array, from_quaternion, pose, to_quaternion

GRAVITY = 9.81  # m/s^2
SOLVER_ITERATIONS = 50
STATIC_FRICTION = 0.8  # of the pod, from its published simulation model; the product of two counts
ITEM_FRICTION = 0.6
ROLLING_FRICTION = 2e-4  # m, keeps a bottle from rolling for ever
STOP = 0.01  # rad or m beyond a joint's limit where its hard stop stands: a servo on it would rattle
DAMPING = 0.04  # 1/s, of a free item's linear and angular velocity

# Bits of the collision groups. Probing rays see items and what stands firm, never the robot.
DEFAULT_GROUP, STATIC_GROUP = 1, 2  # the engine's own, of what moves and of what does not
ITEM_GROUP, FIRM_GROUP = 64, 128
PROBED = ITEM_GROUP | FIRM_GROUP

Colour = tuple[float, float, float, float]


@contextmanager
def _quiet() -> Iterator[None]:
    """pybullet prints from C to stdout and stderr: nothing of it may reach ours."""
    sys.stdout.flush()
    sys.stderr.flush()
    saved = [os.dup(1), os.dup(2)]
    null = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(null, 1)
        os.dup2(null, 2)
        yield
    finally:
        for stream, copy in enumerate(saved, start=1):
            os.dup2(copy, stream)
            os.close(copy)
        os.close(null)


with _quiet():
    import pybullet as p


@dataclass(frozen=True)
class Touch:
    """One contact point between two bodies as the engine found it.

    link_a, link_b: names of the links ("" for bodies of one part)
    depth: m, positive when the shapes overlap
    position: (x, y, z) in the world, m
    """

    a: str
    link_a: str
    b: str
    link_b: str
    depth: float
    position: tuple[float, float, float]
    force: float  # N along the normal


class Engine:
    """A physics world. ``close()`` frees it; so does the garbage collector.

    time_step: s per ``step()``
    """

    def __init__(self, time_step: float) -> None:
        self.time_step = time_step
        with _quiet():
            self._client = p.connect(p.DIRECT)
        self._ids: dict[str, int] = {}
        self._names: dict[int, str] = {}
        self._masses: dict[str, float] = {}  # kg, of free bodies
        self._links: dict[str, dict[str, int]] = {}  # by body: link index by name
        self._link_names: dict[str, dict[int, str]] = {}
        p.setPhysicsEngineParameter(
            fixedTimeStep=time_step,
            numSolverIterations=SOLVER_ITERATIONS,
            # Each pile is solved on its own, and its contacts in the order of its bodies: how exactly must
            # not depend on what happens elsewhere, or on the addresses that decide what is solved together.
            deterministicOverlappingPairs=1,
            minimumSolverIslandSize=0,
            physicsClientId=self._client,
        )
        p.setGravity(0, 0, -GRAVITY, physicsClientId=self._client)

    def close(self) -> None:
        """Free the world; further calls are errors of the caller."""
        if self._client >= 0:
            p.disconnect(physicsClientId=self._client)
            self._client = -1

    def __del__(self) -> None:
        if getattr(self, "_client", -1) >= 0:
            self.close()

    def step(self) -> None:
        """Advance by one time step."""
        p.stepSimulation(physicsClientId=self._client)

    # Bodies ------------------------------------------------------------------------------------------

    def add_static(self, body: Body, T_world_parent: Array, colour: Colour) -> None:
        """A body that never moves, standing in a parent frame."""
        self._create(body.name, body.shape, 0.0, T_world_parent @ body.T_parent_shape, colour)
        self._dynamics(body.name, lateralFriction=STATIC_FRICTION)
        self._group(body.name, STATIC_GROUP | FIRM_GROUP, ~STATIC_GROUP)

    def soften(self, name: str, stiffness: float, damping: float) -> None:
        """Let a body give way where it is touched: stiffness in N/m, damping in Ns/m."""
        self._dynamics(name, contactStiffness=stiffness, contactDamping=damping)

    def add_item(
        self, name: str, item: Item, T_world_item: Array, colour: Colour, mass: float | None = None
    ) -> None:
        """A free body with the item's shape; it may fall asleep.

        Args:
            name: Of the body.
            item: Gives shape and stated mass.
            T_world_item: (4, 4), where it stands.
            colour: Red, green, blue and opacity.
            mass: kg, its true mass where it is not the stated one; it is spread evenly over the shape.
        """
        mass = item.mass if mass is None else mass
        self._create(name, item.shape, mass, T_world_item, colour)
        self._masses[name] = mass
        self._dynamics(
            name,
            # pybullet's own inertia of a cylinder is that of the box around it.
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

    def load_robot(self, name: str, urdf: str, T_world_base: Array) -> None:
        """A serial chain on a fixed base from a URDF's text; its own damping is off.

        Its links collide with each other, but for those that a joint connects.
        """
        with _quiet(), TemporaryDirectory() as folder:
            path = Path(folder) / "robot.urdf"
            path.write_text(urdf, encoding="utf-8")
            body = p.loadURDF(
                str(path),
                basePosition=T_world_base[:3, 3].tolist(),
                baseOrientation=to_quaternion(T_world_base[:3, :3]).tolist(),
                useFixedBase=True,
                flags=p.URDF_USE_SELF_COLLISION | p.URDF_USE_SELF_COLLISION_EXCLUDE_PARENT,
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
        """Take a body out of the world."""
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

    def _register(self, name: str, body: int) -> None:
        self._ids[name], self._names[body] = body, name
        self._links[name], self._link_names[name] = {"": -1}, {-1: ""}

    def _group(self, name: str, group: int, mask: int) -> None:
        p.setCollisionFilterGroupMask(self._ids[name], -1, group, mask, physicsClientId=self._client)

    def _dynamics(self, name: str, link: int = -1, **values: object) -> None:
        p.changeDynamics(self._ids[name], link, physicsClientId=self._client, **values)

    def has_body(self, name: str) -> bool:
        """Whether a body of that name is in the world."""
        return name in self._ids

    def has_link(self, name: str, link: str) -> bool:
        """Whether a body has a link of that name."""
        return link in self._links[name]

    def set_collision(self, a: str, link_a: str, b: str, link_b: str, on: bool) -> None:
        """Whether two parts collide in the physics.

        The engine takes both parts out of its broad phase and puts them back as the newest, which decides
        in which order and from which side their contacts are solved from then on. Whoever switches several
        pairs keeps to one order: that of a set of names is another one in every process.
        """
        p.setCollisionFilterPair(
            self._ids[a], self._ids[b], self._links[a][link_a], self._links[b][link_b], int(on),
            physicsClientId=self._client,
        )  # fmt: skip

    # State -------------------------------------------------------------------------------------------

    def pose(self, name: str, link: str = "") -> Array:
        """``T_world_body`` (4, 4), or of one of its links (the link frame of the URDF)."""
        index = self._links[name][link]
        if index < 0:
            xyz, quaternion = p.getBasePositionAndOrientation(self._ids[name], physicsClientId=self._client)
        else:
            xyz, quaternion = p.getLinkState(
                self._ids[name], index, computeForwardKinematics=1, physicsClientId=self._client
            )[4:6]
        return pose(xyz, R=from_quaternion(quaternion))

    def speed(self, name: str) -> tuple[float, float]:
        """Linear (m/s) and angular (rad/s) speed of a free body."""
        linear, angular = p.getBaseVelocity(self._ids[name], physicsClientId=self._client)
        return float(np.linalg.norm(linear)), float(np.linalg.norm(angular))

    def mass(self, name: str) -> float:
        """True mass of a free body, kg."""
        return self._masses[name]

    def wake(self, name: str) -> None:
        """Wake a sleeping body; making a constraint alone does not."""
        self._dynamics(name, activationState=p.ACTIVATION_STATE_WAKE_UP)

    def sleep(self, name: str) -> None:
        """Let a body sleep until something that moves touches it."""
        self._dynamics(name, activationState=p.ACTIVATION_STATE_SLEEP)

    def fix(self, name: str) -> None:
        """Let a free body stand where it is for good, whatever meets it."""
        p.resetBaseVelocity(self._ids[name], [0.0] * 3, [0.0] * 3, physicsClientId=self._client)
        self._dynamics(name, mass=0.0)

    def touches(self, name: str) -> list[Touch]:
        """Every contact point of a body in the last step whose shapes touch or overlap."""
        found = p.getContactPoints(bodyA=self._ids[name], physicsClientId=self._client)
        return [self._touch(c) for c in found if c[8] <= 0.0]

    def _touch(self, contact: tuple) -> Touch:  # type: ignore[type-arg]
        a, b = self._names[contact[1]], self._names[contact[2]]
        return Touch(
            a, self._link_names[a][contact[3]], b, self._link_names[b][contact[4]],
            -contact[8], contact[5], contact[9],
        )  # fmt: skip

    def near(self, centre: Array, reach: float) -> frozenset[str]:
        """Names of the bodies whose bounding boxes come within ``reach`` m of a point along an axis."""
        found = p.getOverlappingObjects(
            (centre - reach).tolist(), (centre + reach).tolist(), physicsClientId=self._client
        )
        return frozenset(self._names[body] for body, _ in found or ())

    def distance(self, a: str, link_a: str, b: str, farthest: float) -> float:
        """Signed distance between a link and a body in m; ``farthest`` if they are farther apart."""
        points = p.getClosestPoints(
            self._ids[a], self._ids[b], farthest, self._links[a][link_a], physicsClientId=self._client
        )
        return min((float(c[8]) for c in points), default=farthest)

    def ray_hits(self, starts: Array, ends: Array) -> list[tuple[str, float]]:
        """First item or firm body on each ray and the fraction in [0, 1] where; ("", 1.0) where none is."""
        hits = p.rayTestBatch(
            starts.tolist(), ends.tolist(), collisionFilterMask=PROBED, physicsClientId=self._client
        )
        return [(self._names.get(h[0], ""), float(h[2])) if h[0] >= 0 else ("", 1.0) for h in hits]

    # Motors and forces -------------------------------------------------------------------------------

    def joints(self, name: str) -> dict[str, int]:
        """Index by name of every movable joint."""
        body = self._ids[name]
        infos = [
            p.getJointInfo(body, i, physicsClientId=self._client)
            for i in range(p.getNumJoints(body, physicsClientId=self._client))
        ]
        return {info[1].decode(): info[0] for info in infos if info[2] != p.JOINT_FIXED}

    def reset_joints(self, name: str, positions: Mapping[int, float]) -> None:
        """Set joint positions at rest. Only for the start: later the robot moves by its motors alone."""
        for index, value in positions.items():
            p.resetJointState(self._ids[name], index, value, physicsClientId=self._client)

    def joint_states(self, name: str, indices: Sequence[int]) -> tuple[Array, Array]:
        """Positions (k,) of joints by index, and what their motors exerted (k,) in the last step."""
        states = p.getJointStates(self._ids[name], indices, physicsClientId=self._client)
        return np.array([state[0] for state in states]), np.array([state[3] for state in states])

    def inverse_dynamics(self, name: str, q: Array, dq: Array, ddq: Array) -> Array:
        """Motor torques (m,) that a motion of all movable joints needs, by the model in the robot's URDF."""
        torques = p.calculateInverseDynamics(
            self._ids[name], q.tolist(), dq.tolist(), ddq.tolist(), physicsClientId=self._client
        )
        return np.array(torques)

    def drive(self, name: str, indices: Sequence[int], velocities: Array, forces: Array) -> None:
        """Run the motors of joints at velocities (k,), as far as forces (k,) suffice."""
        p.setJointMotorControlArray(
            self._ids[name],
            indices,
            p.VELOCITY_CONTROL,
            targetVelocities=velocities.tolist(),
            forces=forces.tolist(),
            physicsClientId=self._client,
        )

    def velocity(self, name: str, link: str, point: Array) -> tuple[Array, Array]:
        """Velocity (3,) in m/s of a body's material point at a world point (3,), and its turn (3,), rad/s."""
        index = self._links[name][link]
        if index < 0:
            linear, angular = p.getBaseVelocity(self._ids[name], physicsClientId=self._client)
            centre = p.getBasePositionAndOrientation(self._ids[name], physicsClientId=self._client)[0]
        else:
            state = p.getLinkState(
                self._ids[name], index, computeLinkVelocity=1, computeForwardKinematics=1,
                physicsClientId=self._client,
            )  # fmt: skip
            linear, angular, centre = state[6], state[7], state[0]
        turn = np.array(angular)
        return np.array(linear) + _cross(turn, point - np.array(centre)), turn

    def push(self, name: str, force: Array, point: Array, link: str = "") -> None:
        """Force (3,) in N at a world point (3,) on a body or its link, for the next step only."""
        p.applyExternalForce(
            self._ids[name], self._links[name][link], force.tolist(), point.tolist(), p.WORLD_FRAME,
            physicsClientId=self._client,
        )  # fmt: skip

    def twist(self, name: str, torque: Array, link: str = "") -> None:
        """Torque (3,) in Nm, world axes, on a body or its link, for the next step only."""
        p.applyExternalTorque(
            self._ids[name], self._links[name][link], torque.tolist(), p.WORLD_FRAME,
            physicsClientId=self._client,
        )  # fmt: skip

    def keep_awake(self, name: str, on: bool) -> None:
        """Whether a free body must not fall asleep, as one that hangs in the cup; it wakes either way."""
        state = p.ACTIVATION_STATE_DISABLE_SLEEPING if on else p.ACTIVATION_STATE_ENABLE_SLEEPING
        self._dynamics(name, activationState=state)
        self.wake(name)

    # Pictures ----------------------------------------------------------------------------------------

    def picture(
        self, eye: Sequence[float], target: Sequence[float], fov: float, size: tuple[int, int]
    ) -> NDArray[np.uint8]:
        """Colour picture (height, width, 3) uint8 by the software renderer, z up; fov in degrees."""
        width, height = size
        view = p.computeViewMatrix(list(eye), list(target), [0, 0, 1])
        projection = p.computeProjectionMatrixFOV(fov, width / height, 0.05, 10.0)
        image = p.getCameraImage(
            width, height, view, projection, shadow=1, lightDirection=[-1.5, 0.8, 2.5],
            renderer=p.ER_TINY_RENDERER, physicsClientId=self._client,
        )  # fmt: skip
        return np.asarray(image[2], dtype=np.uint8).reshape(height, width, 4)[:, :, :3]


def _cross(a: Array, b: Array) -> Array:
    """Cross product of two (3,) arrays; numpy's takes ten times as long."""
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def _shape_arguments(shape: Shape, length_name: str) -> dict[str, object]:
    """pybullet's keywords for a shape; it calls a cylinder's length by two names."""
    if shape.kind is ShapeKind.BOX:
        return {"shapeType": p.GEOM_BOX, "halfExtents": [s / 2 for s in shape.size]}
    if shape.kind is ShapeKind.CYLINDER:
        return {"shapeType": p.GEOM_CYLINDER, "radius": shape.size[0], length_name: shape.size[1]}
    return {"shapeType": p.GEOM_SPHERE, "radius": shape.size[0]}
