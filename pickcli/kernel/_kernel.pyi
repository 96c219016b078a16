"""
Kinematics, clearance and proven edges of a serial chain; paces along paths; prioritized control; rays of cameras.

Any array-like goes in; C-contiguous arrays of the named dtype are read in place. Angles in rad, lengths in m.
Wrong shapes and values raise ValueError naming the argument.
"""

from collections.abc import Sequence
import enum

import numpy
import numpy.typing


class JointKind(enum.IntEnum):
    """How a joint moves its child."""

    REVOLUTE = 0
    """About its axis, with limits or without."""

    PRISMATIC = 1
    """Along its axis."""

    FIXED = 2
    """Not at all."""

class FollowEnd(enum.IntEnum):
    """Why following a row of poses ended."""

    DONE = 0
    """All were reached."""

    NO_CONVERGENCE = 1
    """No configuration was found for the next one."""

    JOINT_STEP = 2
    """A joint would step over the largest step."""

    LIMIT = 3
    """None was found for the next one, with a joint pressed against a limit."""

    OFF_LINE = 4
    """The tip would leave the line on the way to the next one."""

class TrackEnd(enum.IntEnum):
    """Why tracking a motion of the tip ended."""

    DONE = 0
    """All of it was tracked."""

    SINGULAR = 1
    """A joint would be many times too fast."""

    LIMIT = 2
    """A joint would be beyond a limit."""

def line_deviation(T_world_tips: numpy.typing.NDArray[numpy.float64]) -> tuple[float, float]:
    """
    How far poses leave the straight line from the first to the last, at most.

    Args:
        T_world_tips: (N, 4, 4) m, N at least 2.

    Returns:
        m from the nearest point of the line; rad from how a steady turn about one axis stands there.
    """

class Chain:
    """
    A serial chain: at most 63 joints, of which at most 32 entries of q move any.

    Frame k is the child link of joint k; the parent of joint k is frame k-1, that of joint 0 the world.
    """

    def __init__(self, joint_types: numpy.typing.NDArray[numpy.int32], T_parent_joint: numpy.typing.NDArray[numpy.float64], axes: numpy.typing.NDArray[numpy.float64], q_index: numpy.typing.NDArray[numpy.int32]) -> None:
        """
        Make a chain from the base outwards.

        Args:
            joint_types: (L,) of JointKind.
            T_parent_joint: (L, 4, 4) m, pose of the joint frame in frame k-1 (k = 0: in the world) at position 0.
            axes: (L, 3) in the joint frame, normalised here; ignored for fixed joints.
            q_index: (L,) entry of q that moves the joint, -1 for fixed ones; every entry 0..n-1 is used.

        Raises:
            ValueError: What is given is no chain; names the argument.
        """

    @property
    def n(self) -> int:
        """Length of a configuration."""

    @property
    def n_frames(self) -> int:
        """Number of frames L."""

    def fk(self, q: numpy.typing.NDArray[numpy.float64]) -> numpy.typing.NDArray[numpy.float64]:
        """
        Poses (L, 4, 4) of all frames in the world, in m, at q (n,) in rad or m.
        """

    def fk_batch(self, Q: numpy.typing.NDArray[numpy.float64]) -> numpy.typing.NDArray[numpy.float64]:
        """
        Poses (N, L, 4, 4) of all frames in the world, in m, at each of the configurations Q (N, n).
        """

    def tips(self, Q: numpy.typing.NDArray[numpy.float64], T_last_tip: numpy.typing.NDArray[numpy.float64]) -> numpy.typing.NDArray[numpy.float64]:
        """
        Poses of the tip.

        Args:
            Q: (N, n) configurations in rad or m.
            T_last_tip: (4, 4) pose of the tip in frame L-1, m.

        Returns:
            (N, 4, 4) in the world, in m.
        """

    def jacobian(self, q: numpy.typing.NDArray[numpy.float64], T_last_tip: numpy.typing.NDArray[numpy.float64]) -> numpy.typing.NDArray[numpy.float64]:
        """
        Jacobian of the tip.

        Args:
            q: (n,) configuration in rad or m.
            T_last_tip: (4, 4) pose of the tip in frame L-1, m.

        Returns:
            (6, n): linear x y z in m, then angular x y z in rad, both along the axes of the world.
        """

    def tip_motion(self, Q: numpy.typing.NDArray[numpy.float64], dQ: numpy.typing.NDArray[numpy.float64], ddQ: numpy.typing.NDArray[numpy.float64], T_last_tip: numpy.typing.NDArray[numpy.float64]) -> tuple[numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64]]:
        """
        Poses and motion of the tip along a path or trajectory, in the axes of the world.

        Args:
            Q: (N, n) configurations in rad or m.
            dQ: (N, n) their first derivatives by time or by a path's parameter.
            ddQ: (N, n) their second derivatives by the same.
            T_last_tip: (4, 4) pose of the tip in frame L-1, m.

        Returns:
            Poses (N, 4, 4) of the tip in the world, and motions (N, 4, 3), whose rows are velocity, angular velocity,
            acceleration and angular acceleration, in m and rad per the derivatives' unit.
        """

    def resolved_rates(self, Q: numpy.typing.NDArray[numpy.float64], own: numpy.typing.NDArray[numpy.float64], twists: numpy.typing.NDArray[numpy.float64], T_last_tip: numpy.typing.NDArray[numpy.float64], velocity: numpy.typing.NDArray[numpy.float64]) -> numpy.typing.NDArray[numpy.float64]:
        """
        Joint velocities that move the tip as wanted, those of least norm besides given ones (Whitney 1969).

        Args:
            Q: (N, n) configurations in rad or m.
            own: (N, n) velocities that the joints have anyway, per s.
            twists: (N, 6) wanted of the tip along the axes of the world: m/s, then rad/s.
            T_last_tip: (4, 4) pose of the tip in frame L-1, m.
            velocity: (n,) > 0, limits by which the velocities of the joints are measured.

        Returns:
            (N, n) per s. In a singular configuration they give another twist, or are not finite.
        """

    def track_tip(self, times: numpy.typing.NDArray[numpy.float64], own: numpy.typing.NDArray[numpy.float64], T_world_tips: numpy.typing.NDArray[numpy.float64], twists: numpy.typing.NDArray[numpy.float64], own_between: numpy.typing.NDArray[numpy.float64], twists_between: numpy.typing.NDArray[numpy.float64], met: int, q_met: numpy.typing.NDArray[numpy.float64], T_last_tip: numpy.typing.NDArray[numpy.float64], lower: numpy.typing.NDArray[numpy.float64], upper: numpy.typing.NDArray[numpy.float64], velocity: numpy.typing.NDArray[numpy.float64], fastest: float) -> tuple[numpy.typing.NDArray[numpy.float64], TrackEnd, int, int]:
        """
        Configurations along a motion of the tip, by integration of ``resolved_rates`` from one of them.

        Each step, by Runge and Kutta of the fourth order, is followed by one of least norm onto the pose.

        Args:
            times: (N,) s, increasing, N at least 2.
            own: (N, n) velocities that the joints have anyway, per s.
            T_world_tips: (N, 4, 4) m, wanted poses of the tip.
            twists: (N, 6) wanted of the tip along the axes of the world: m/s, then rad/s.
            own_between: (N-1, n) the same half-way between the times.
            twists_between: (N-1, 6) the same half-way between the times.
            met: Index of the time at which the configuration is known.
            q_met: (n,) rad or m, that configuration.
            T_last_tip: (4, 4) pose of the tip in frame L-1, m.
            lower: (n,) rad or m.
            upper: (n,) rad or m.
            velocity: (n,) > 0, limits by which the velocities of the joints are measured.
            fastest: Times these limits, from which on the arm counts as singular.

        Returns:
            (N, n) configurations, not all of them known unless it was done; why it ended; if it was not done, the
            index of the time that was not reached, and the joint that is farthest beyond its limit there.
        """

    def inverse_dynamics(self, Q: numpy.typing.NDArray[numpy.float64], dQ: numpy.typing.NDArray[numpy.float64], ddQ: numpy.typing.NDArray[numpy.float64], masses: numpy.typing.NDArray[numpy.float64], centres: numpy.typing.NDArray[numpy.float64], inertias: numpy.typing.NDArray[numpy.float64], gravity: float) -> numpy.typing.NDArray[numpy.float64]:
        """
        Efforts of the joints that move rigid links as required, by the equations of Newton and Euler.

        Args:
            Q: (N, n) configurations in rad or m.
            dQ: (N, n) their first derivatives by time or by a path's parameter.
            ddQ: (N, n) their second derivatives by the same.
            masses: (L,) kg of the body fixed to each frame.
            centres: (L, 3) centre of mass in its frame, m.
            inertias: (L, 3, 3) about the centre of mass, in the axes of the frame, kg m^2.
            gravity: Acceleration along -z of the world, m/s^2.

        Returns:
            (N, n) Nm, or N of prismatic joints.
        """

    def ik(self, T_world_target: numpy.typing.NDArray[numpy.float64], T_last_tip: numpy.typing.NDArray[numpy.float64], seeds: numpy.typing.NDArray[numpy.float64], lower: numpy.typing.NDArray[numpy.float64], upper: numpy.typing.NDArray[numpy.float64], weights: numpy.typing.NDArray[numpy.float64], max_iterations: int = 60, position_tolerance: float = 1e-05, rotation_tolerance: float = 0.0001, distinct: float = 0.05) -> numpy.typing.NDArray[numpy.float64]:
        """
        Configurations that bring the tip to a pose, found from seeds.

        By damped least squares (Levenberg-Marquardt). Deterministic: the same arguments give the same bits.

        Args:
            T_world_target: (4, 4) where the tip is to be, m.
            T_last_tip: (4, 4) pose of the tip in frame L-1, m.
            seeds: (K, n) configurations to start from.
            lower: (n,) limits that all solutions keep.
            upper: (n,) limits that all solutions keep.
            weights: (n,) > 0; a joint with a larger one moves less.
            max_iterations: For each seed.
            position_tolerance: m.
            rotation_tolerance: rad.
            distinct: rad or m; a solution within it of an earlier one in every joint is left out.

        Returns:
            (M, n) in the order of their seeds.
        """

    def follow(self, T_world_targets: numpy.typing.NDArray[numpy.float64], T_last_tip: numpy.typing.NDArray[numpy.float64], q0: numpy.typing.NDArray[numpy.float64], lower: numpy.typing.NDArray[numpy.float64], upper: numpy.typing.NDArray[numpy.float64], weights: numpy.typing.NDArray[numpy.float64], max_step: numpy.typing.NDArray[numpy.float64], position_deviation: float, angle_deviation: float) -> tuple[numpy.typing.NDArray[numpy.float64], FollowEnd, tuple[float, float]]:
        """
        Follow a row of poses, each solved from the solution before it.

        Args:
            T_world_targets: (P, 4, 4) where the tip is to be, one after the other, m.
            T_last_tip: (4, 4) pose of the tip in frame L-1, m.
            q0: (n,) where the arm comes from.
            lower: (n,) limits that all configurations keep.
            upper: (n,) limits that all configurations keep.
            weights: (n,) > 0; a joint with a larger one moves less.
            max_step: (n,) rad or m, largest step of each joint from one pose to the next, and from q0 to the first.
            position_deviation: m that the tip may be off half-way between two poses.
            angle_deviation: rad that it may be off there.

        Returns:
            Configurations (n_done, n) of the first n_done poses, why it ended, and by how many m and rad the tip was off
            half-way at the end.
        """

    def longest_chords(self, Q: numpy.typing.NDArray[numpy.float64], T_world_tips: numpy.typing.NDArray[numpy.float64], T_last_tip: numpy.typing.NDArray[numpy.float64], position_deviation: float, angle_deviation: float) -> numpy.typing.NDArray[numpy.int32]:
        """
        The waypoints on a straight line that are enough: joint chords between them stay near it.

        Args:
            Q: (N, n) configurations that follow the line, N at least 1.
            T_world_tips: (N, 4, 4) poses of the tip on the line, m.
            T_last_tip: (4, 4) pose of the tip in frame L-1, m.
            position_deviation: m that the tip may be off the line, however far along it.
            angle_deviation: rad that it may be off the pose at the same place.

        Returns:
            Indices (M,) of rows of Q, the first and the last among them.
        """

class SolidKind(enum.IntEnum):
    """What a solid is, before its rounding."""

    BOX = 0
    """By its half extents."""

    CYLINDER = 1
    """About its z; half extents (radius, radius, half length)."""

    SPHERE = 2
    """Half extents three times its radius."""

class ContactKind(enum.IntEnum):
    """What a frame meets."""

    NONE = -1
    """Nothing."""

    WORLD = 0
    """A solid of the world."""

    SELF = 1
    """Another frame."""

    CLOUD = 2
    """A point of the world's cloud."""

class EdgeReport:
    """Whether an edge is free, and if not, where and why."""

    @property
    def free(self) -> bool:
        """Whether every point of the edge is proven free."""

    @property
    def t(self) -> float:
        """
        Where on the edge, 0 at q0 and 1 at q1, it was found not free; -1 if it is.
        """

    @property
    def frame(self) -> int:
        """
        The frame that is not free there, L for the held item; -1 if the edge is free.
        """

    @property
    def kind(self) -> ContactKind:
        """What it meets there; NONE if the edge is free."""

    @property
    def index(self) -> int:
        """
        Index of the solid or the point, or the frame nearer to the base; -1 if the edge is free.
        """

    @property
    def n_configurations(self) -> int:
        """How many configurations were tested."""

class Checker:
    """
    Collision checks of a chain whose frames carry spheres, in a world of boxes, cylinders and spheres.

    Checks may run in several threads; set_world and set_held must not run meanwhile.
    """

    def __init__(self, chain: Chain, centers: numpy.typing.NDArray[numpy.float64], radii: numpy.typing.NDArray[numpy.float64], frame: numpy.typing.NDArray[numpy.int32], self_pairs: numpy.typing.NDArray[numpy.int32], fine_centers: numpy.typing.NDArray[numpy.float64] | None = None, fine_radii: numpy.typing.NDArray[numpy.float64] | None = None, fine_frame: numpy.typing.NDArray[numpy.int32] | None = None) -> None:
        """
        Make a checker in an empty world.

        Args:
            chain: The robot's.
            centers: (S, 3) of spheres in their frames, m.
            radii: (S,) m.
            frame: (S,) in 0..L-1, that carries each.
            self_pairs: (P, 2) pairs of frames that must stay clear of each other.
            fine_centers: (F, 3) of tighter spheres, m. Two frames are clear of each other where either their spheres
                are or these, of a frame that has any; what is held is tested against these alone.
            fine_radii: (F,) m.
            fine_frame: (F,) in 0..L-1, that carries each.
        """

    @property
    def rounding(self) -> float:
        """
        Bound in m on what is_free, are_free and edges add to the margin for single precision.

        It holds for at most 1 m of prismatic travel, and grows with travel.
        """

    def bare(self) -> Checker:
        """
        The same robot with nothing around it and nothing held: a fraction of the time that its spheres take.
        """

    def set_world(self, T_world_box: numpy.typing.NDArray[numpy.float64], half_extents: numpy.typing.NDArray[numpy.float64], ignored_frames: numpy.typing.NDArray[numpy.uint64], kind: numpy.typing.NDArray[numpy.int32] | None = None, rounding: numpy.typing.NDArray[numpy.float64] | None = None) -> None:
        """
        Replace the solids of the world; its cloud stays.

        Args:
            T_world_box: (B, 4, 4) poses of the solids' boxes, m.
            half_extents: (B, 3) of the boxes, m; see SolidKind.
            ignored_frames: (B,) bit f set: frame f is never tested against the solid; bit L is the held item.
            kind: (B,) of SolidKind; all are boxes unless given.
            rounding: (B,) m, adds every point within that distance; 0 unless given.
        """

    def set_cloud(self, centers: numpy.typing.NDArray[numpy.float64], radius: float, edge: float = 0.0, voxel: float = 0.0, ignored_frames: int = 0) -> None:
        """
        Replace the cloud of the world, points or the cubes of an occupancy grid; the solids stay.

        Nothing comes nearer to any point of the cloud than radius and the margin that is asked for. Where voxel is
        given, the points in one of its cells become one ball around them, which holds no less. Distances are those
        from the cloud as it is kept, in single precision and rounded outwards.

        Args:
            centers: (N, 3) m, in the world; none: no cloud.
            radius: m around each that counts as it.
            edge: m, of a cube around each, along the axes of the world; 0: points.
            voxel: m, edge of the cells of the filter; 0: every point is kept.
            ignored_frames: Bit f set: frame f is never tested against the cloud; bit L is the held item.
        """

    def share_cloud(self, other: Checker, ignored_frames: int = 0) -> None:
        """
        Replace the cloud of the world by that of another checker, which is not copied.

        Args:
            other: The other checker.
            ignored_frames: Bit f set: frame f is never tested against the cloud; bit L is the held item.
        """

    def set_held(self, centers: numpy.typing.NDArray[numpy.float64], radii: numpy.typing.NDArray[numpy.float64], tested_frames: numpy.typing.NDArray[numpy.int32]) -> None:
        """
        Replace the held item by spheres, rigid in frame L-1; empty arrays: nothing is held.

        Args:
            centers: (H, 3) in frame L-1, m.
            radii: (H,) m.
            tested_frames: (T,) frames that the spheres must stay clear of.
        """

    def set_held_solid(self, T_last_solid: numpy.typing.NDArray[numpy.float64], half_extents: numpy.typing.NDArray[numpy.float64], tested_frames: numpy.typing.NDArray[numpy.int32], kind: int = 0, rounding: float = 0.0) -> None:
        """
        Replace the held item by one solid, rigid in frame L-1.

        Its distance from the frames is exact. That from the world is judged by the widest slab between the two that a
        few directions give: never too large, and too small by a few per mille at most.

        Args:
            T_last_solid: (4, 4) pose in frame L-1, m.
            half_extents: (3,) m; see SolidKind.
            tested_frames: (T,) frames that the solid must stay clear of.
            kind: Of SolidKind.
            rounding: m, adds every point within that distance.
        """

    def is_free(self, q: numpy.typing.NDArray[numpy.float64], margin: float = 0.0) -> bool:
        """Whether everything at q (n,) keeps more than margin, in m."""

    def are_free(self, Q: numpy.typing.NDArray[numpy.float64], margin: float = 0.0) -> numpy.typing.NDArray[numpy.bool_]:
        """
        Whether everything keeps more than margin, in m, at each of Q (N, n): (N,).
        """

    def edge_is_free(self, q0: numpy.typing.NDArray[numpy.float64], q1: numpy.typing.NDArray[numpy.float64], margin: float = 0.0, slack: numpy.typing.NDArray[numpy.float64] | None = None, resolution: float = 0.0002) -> bool:
        """
        Whether every configuration on a straight segment, and in a tube around it, is proven free.

        True is a proof. False means that some point of it comes closer than margin plus what slack moves it plus
        resolution, where splitting the edge further ends.

        Args:
            q0: (n,) where the edge begins.
            q1: (n,) where it ends.
            margin: m that everything keeps more than.
            slack: (n,) rad or m, half width of the tube in each joint; none unless given.
            resolution: m, distance up to which an edge is split.
        """

    def first_blocked_edge(self, Q: numpy.typing.NDArray[numpy.float64], margin: float = 0.0, slack: numpy.typing.NDArray[numpy.float64] | None = None, resolution: float = 0.0002) -> int:
        """
        Index of the first edge of a polyline that is not proven free, -1 if all are.

        Args:
            Q: (N, n) vertices; a single one counts as an edge of no length.
            margin: m that everything keeps more than.
            slack: (N-1, n) rad or m, half width of the tube around each edge; none unless given.
            resolution: m, distance up to which an edge is split.
        """

    def check_edge(self, q0: numpy.typing.NDArray[numpy.float64], q1: numpy.typing.NDArray[numpy.float64], margin: float = 0.0, slack: numpy.typing.NDArray[numpy.float64] | None = None, resolution: float = 0.0002) -> EdgeReport:
        """
        Whether a straight segment, and a tube around it, is proven free, and where it is not.

        Args:
            q0: (n,) where the edge begins.
            q1: (n,) where it ends.
            margin: m that everything keeps more than.
            slack: (n,) rad or m, half width of the tube in each joint; none unless given.
            resolution: m, distance up to which an edge is split.

        Returns:
            Whether it is free, as from edge_is_free; if not, the place on the edge.
        """

    def clearance(self, q: numpy.typing.NDArray[numpy.float64], max_distance: float = 1.0) -> tuple[float, int, ContactKind, int]:
        """
        Signed distance of the nearest pair at a configuration, in double precision.

        Against a box it is negative by the depth of the sphere below the nearest face.

        Args:
            q: (n,) configuration.
            max_distance: m beyond which nothing is looked for.

        Returns:
            Distance in m, frame, kind and index as in EdgeReport; (max_distance, -1, NONE, -1) if nothing is
            nearer.
        """

    def clearances(self, Q: numpy.typing.NDArray[numpy.float64], max_distance: float = 1.0) -> numpy.typing.NDArray[numpy.float64]:
        """The distances (N,) in m that clearance finds at each of Q (N, n)."""

    def near_pairs(self, q: numpy.typing.NDArray[numpy.float64], influence: float) -> tuple[numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.int32]]:
        """
        Pairs of frames and solids or other frames that are near each other, with gradients of their distances.

        Args:
            q: (n,) configuration.
            influence: m, beyond which no pair counts.

        Returns:
            (K,) signed distances in m, of the few nearest spheres of each pair; (K, n) their gradients, in m per rad or
            m; and (K, 3) frame, kind (a ContactKind) and index of each pair, as in EdgeReport.

        Raises:
            ValueError: A solid is held.
        """

    def clearest(self, Q: numpy.typing.NDArray[numpy.float64], n_most: int, max_distance: float = 1.0) -> tuple[numpy.typing.NDArray[numpy.int32], numpy.typing.NDArray[numpy.float64]]:
        """
        The configurations with the largest clearances, in a fraction of the time that all clearances take.

        Args:
            Q: (N, n) configurations.
            n_most: How many are wanted.
            max_distance: m beyond which nothing is looked for.

        Returns:
            Rows (K,) of Q, K = min(N, n_most), the clearest first, equal ones in their order; and their clearances
            (K,) in m.
        """

def rrt_connect(checker: Checker, start: numpy.typing.NDArray[numpy.float64], goals: numpy.typing.NDArray[numpy.float64], lower: numpy.typing.NDArray[numpy.float64], upper: numpy.typing.NDArray[numpy.float64], seed: int, max_iterations: int, step: float, margin: float = 0.0, resolution: float = 0.0002) -> numpy.typing.NDArray[numpy.float64]:
    """
    Waypoints from a start to one of several goals by RRT-Connect.

    Kuffner and LaValle 2000, but the smaller tree grows, from nodes before an obstacle only towards what is near
    (Yershova et al. 2005), and long searches begin anew with shorter edges. Every edge is proven as by
    Checker.edge_is_free; start and goals are not asked about. The same arguments give the same bits.

    Args:
        checker: Proves the edges.
        start: (n,) root of the first tree.
        goals: (G, n) roots of the second tree.
        lower: (n,) between which configurations are drawn.
        upper: (n,) between which configurations are drawn.
        seed: Of the draws.
        max_iterations: After which nothing was found.
        step: Longest edge of a tree, Euclidean in joint space; 1e-6 at least.
        margin: m, as of Checker.edge_is_free.
        resolution: m, as of Checker.edge_is_free.

    Returns:
        (K, n), or (0, n) if none was found.
    """

def shorten(checker: Checker, Q: numpy.typing.NDArray[numpy.float64], shortcuts: numpy.typing.NDArray[numpy.float64], velocity: numpy.typing.NDArray[numpy.float64], calm: float, worthwhile: float, margin: float = 0.0, resolution: float = 0.0002) -> numpy.typing.NDArray[numpy.float64]:
    """
    A polyline with the same ends that costs no more, by shortcuts (Geraerts and Overmars 2007).

    An edge dq costs the largest abs(dq_j) / velocity_j, and calm times the length of dq / velocity. Vertices that
    a proven edge skips go; then the shortcuts are tried in their order; then vertices go again. Every new edge,
    also what is left of one that was cut, is proven as by Checker.edge_is_free; those of Q are taken to be.

    Args:
        checker: Proves the edges.
        Q: (N, n) vertices.
        shortcuts: (S, 2) increasing shares, 0..1, of the cost of the polyline as it is then: each joins the
            points there.
        velocity: (n,) > 0, rad/s or m/s.
        calm: Share.
        worthwhile: Share of the whole cost that a shortcut must save to be taken.
        margin: m, as of Checker.edge_is_free.
        resolution: m, as of Checker.edge_is_free.

    Returns:
        (K, n) vertices.
    """

def simplified_polyline(waypoints: numpy.typing.NDArray[numpy.float64], tolerances: numpy.typing.NDArray[numpy.float64], same: float, nowhere: float) -> numpy.typing.NDArray[numpy.int32]:
    """
    Indices of the waypoints that shape a path, after Douglas and Peucker (1973).

    Args:
        waypoints: (N, n) configurations, N >= 1.
        tolerances: (N,) > 0, how far a dropped waypoint may be off the chord between its kept neighbours, joint units.
        same: Waypoints nearer than this count as one, joint units.
        nowhere: A path no longer than this has no motion, joint units.

    Returns:
        (K,) indices, increasing: the first, the last and all that are needed. Those between two kept ones advance
        along their chord, so reversals are kept.
    """

def fastest_pace(s: numpy.typing.NDArray[numpy.float64], dq: numpy.typing.NDArray[numpy.float64], ddq: numpy.typing.NDArray[numpy.float64], acceleration: numpy.typing.NDArray[numpy.float64], speed: numpy.typing.NDArray[numpy.float64], line_speed: numpy.typing.NDArray[numpy.float64], is_line: numpy.typing.NDArray[numpy.int32], cruise: float = 0.0) -> tuple[numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64]]:
    """
    Time-optimal motion from rest to rest along a path, by TOPP-RA (Pham and Pham 2018).

    Args:
        s: (M,) gridpoints, increasing.
        dq: (M, n) dq/ds at the gridpoints.
        ddq: (M, n) its derivative by s.
        acceleration: (M-1, n) > 0, rad/s^2 or m/s^2, limits of the joints on each interval.
        speed: (M,) 1/s, limits of ds/dt.
        line_speed: (M-1,) 1/s, limits of ds/dt inside intervals that are lines.
        is_line: (M-1,) whether nothing bends there; the profile of a line is exact: accelerate, cruise, brake.
        cruise: s that the cruise on a line lasts at least.

    Returns:
        t, s and ds/dt, each (P,); ds/dt is linear in t between the points.
    """

def smoothed_pace(t: numpy.typing.NDArray[numpy.float64], s: numpy.typing.NDArray[numpy.float64], v: numpy.typing.NDArray[numpy.float64], step: float, n_window: int) -> tuple[numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64]]:
    """
    A motion with its speed averaged over a window, which bounds its jerk.

    Args:
        t: (P,) s, increasing from 0.
        s: (P,) path parameters.
        v: (P,) ds/dt, linear in t between the points, 0 at both ends.
        step: s between the times of the result.
        n_window: Steps of the window, at least 1.

    Returns:
        s, ds/dt and d2s/dt2 at even times, each (K,): a window and a step longer than the motion, d2s/dt2 linear in
        between.
    """

def estimated_duration(waypoints: numpy.typing.NDArray[numpy.float64], velocity: numpy.typing.NDArray[numpy.float64], acceleration: numpy.typing.NDArray[numpy.float64], corner_deviation: float) -> float:
    """
    About how many seconds a polyline with blended corners takes from rest to rest.

    The look-ahead of machine tools: on each edge the speed is bounded by the slowest joint, in each corner by the
    acceleration that a blend needs; a pass backwards and one forwards make the speeds reachable; each edge then
    takes its trapezoid. Jerk is left out.

    Args:
        waypoints: (N, n) vertices, rad or m.
        velocity: (n,) > 0, rad/s or m/s.
        acceleration: (n,) > 0, rad/s^2 or m/s^2.
        corner_deviation: rad or m, by which a blend may leave its corner.
    """

def quintic_peaks(times: numpy.typing.NDArray[numpy.float64], positions: numpy.typing.NDArray[numpy.float64], velocities: numpy.typing.NDArray[numpy.float64], accelerations: numpy.typing.NDArray[numpy.float64]) -> tuple[numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64]]:
    """
    Largest values on the quintics between points in time.

    Args:
        times: (N,) s, increasing.
        positions: (N, n) rad or m.
        velocities: (N, n) per s.
        accelerations: (N, n) per s^2.

    Returns:
        Of every piece, each (N-1, n): the largest abs(velocity), from above; abs(acceleration) and abs(jerk),
        exact.
    """

def quintic_states(times: numpy.typing.NDArray[numpy.float64], positions: numpy.typing.NDArray[numpy.float64], velocities: numpy.typing.NDArray[numpy.float64], accelerations: numpy.typing.NDArray[numpy.float64], t: numpy.typing.NDArray[numpy.float64], highest: int = 2) -> numpy.typing.NDArray[numpy.float64]:
    """
    States on the quintics between points in time.

    Args:
        times: (N,) s, increasing.
        positions: (N, n) rad or m.
        velocities: (N, n) per s.
        accelerations: (N, n) per s^2.
        t: (M,) s, clamped to the first and the last time.
        highest: Derivative by time, 0 to 2.

    Returns:
        (highest + 1, M, n).
    """

class BlendedPolyline:
    """
    A polyline whose corners are smoothed, by its arc length s.

    At corner k the direction changes by a turn within h_k: the slope of the ramp is the quintic smoothstep there.
    Lengths are Euclidean in joint units, rad and m alike.
    """

    def __init__(self, corners: numpy.typing.NDArray[numpy.float64], corner_s: numpy.typing.NDArray[numpy.float64], half_lengths: numpy.typing.NDArray[numpy.float64], directions: numpy.typing.NDArray[numpy.float64], turns: numpy.typing.NDArray[numpy.float64]) -> None:
        """
        Make a curve; nothing is computed that is given.

        Args:
            corners: (K, n), K >= 1.
            corner_s: (K,) arc length of every corner, increasing from 0.
            half_lengths: (K,) h of every corner; 0 where nothing is smoothed.
            directions: (K + 1, n) unit vectors before and after every corner.
            turns: (K, n) change of direction at every corner.
        """

    def evaluate(self, s: numpy.typing.NDArray[numpy.float64], highest: int = 3) -> numpy.typing.NDArray[numpy.float64]:
        """
        The configuration and its derivatives by s.

        Args:
            s: (M,), clamped to the curve.
            highest: Derivative, 0 to 3.

        Returns:
            (highest + 1, M, n).
        """

    def needed_time_scale(self, t: numpy.typing.NDArray[numpy.float64], s: numpy.typing.NDArray[numpy.float64], ds: numpy.typing.NDArray[numpy.float64], dds: numpy.typing.NDArray[numpy.float64], velocity: numpy.typing.NDArray[numpy.float64], acceleration: numpy.typing.NDArray[numpy.float64], jerk: numpy.typing.NDArray[numpy.float64], scale: numpy.typing.NDArray[numpy.float64]) -> numpy.typing.NDArray[numpy.float64]:
        """
        Factors of time at which a motion along the curve, by quintics between points, keeps its limits.

        Args:
            t: (K,) s, increasing.
            s: (K,) where on the curve.
            ds: (K,) 1/s, its first derivative by time.
            dds: (K,) 1/s^2, its second.
            velocity: (n,) limits, rad/s or m/s.
            acceleration: (n,) limits, rad/s^2 or m/s^2.
            jerk: (n,) limits, rad/s^3 or m/s^3.
            scale: (K-1,) of all limits, between each point and the next.

        Returns:
            (K-1,) between each point and the next, at least 1.
        """

    def knots(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        Sorted s (M,) of both ends, of all stops, and of nodes within the blends, dense where the path bends fast.

        Between two knots that lie in no blend the path is a straight line.
        """

    def are_lines(self, start: numpy.typing.NDArray[numpy.float64], end: numpy.typing.NDArray[numpy.float64]) -> numpy.typing.NDArray[numpy.bool_]:
        """
        Whether nothing bends (M,) on each of the intervals start (M,) to end (M,), which lie between knots.
        """

    def second_derivative_bound(self, start: numpy.typing.NDArray[numpy.float64], end: numpy.typing.NDArray[numpy.float64]) -> numpy.typing.NDArray[numpy.float64]:
        """
        Upper bounds (M, n) of the second derivative's size on each of the intervals start (M,) to end (M,).
        """

    def third_derivative_bound(self, start: numpy.typing.NDArray[numpy.float64], end: numpy.typing.NDArray[numpy.float64]) -> numpy.typing.NDArray[numpy.float64]:
        """
        Upper bounds (M, n) of the third derivative's size on each of the intervals start (M,) to end (M,).
        """

    def deviation(self, start: numpy.typing.NDArray[numpy.float64], end: numpy.typing.NDArray[numpy.float64]) -> numpy.typing.NDArray[numpy.float64]:
        """
        Upper bounds (M,) of the Euclidean distance from the polyline on intervals start (M,) to end (M,).
        """

class JointState:
    """Positions and velocities of all joints at one time."""

    def __init__(self, q: numpy.typing.NDArray[numpy.float64], v: numpy.typing.NDArray[numpy.float64]) -> None:
        """The state at q (n,), rad or m, with velocities v (n,)."""

    @staticmethod
    def at_rest(q: numpy.typing.NDArray[numpy.float64]) -> JointState:
        """The state at rest in q (n,)."""

    @property
    def q(self) -> numpy.typing.NDArray[numpy.float64]:
        """(n,) rad or m."""

    @property
    def v(self) -> numpy.typing.NDArray[numpy.float64]:
        """(n,) rad/s or m/s."""

class ParabolicLimits:
    """What each joint may do."""

    def __init__(self, velocity: numpy.typing.NDArray[numpy.float64], acceleration: numpy.typing.NDArray[numpy.float64], jerk: numpy.typing.NDArray[numpy.float64], pause: float) -> None:
        """
        State limits.

        Args:
            velocity: (n,) rad/s or m/s.
            acceleration: (n,) rad/s^2 or m/s^2.
            jerk: (n,) rad/s^3 or m/s^3.
            pause: s without acceleration between a ramp up and a ramp down.
        """

    @property
    def velocity(self) -> numpy.typing.NDArray[numpy.float64]:
        """(n,) rad/s or m/s."""

    @property
    def acceleration(self) -> numpy.typing.NDArray[numpy.float64]:
        """(n,) rad/s^2 or m/s^2."""

    @property
    def jerk(self) -> numpy.typing.NDArray[numpy.float64]:
        """(n,) rad/s^3 or m/s^3."""

    @property
    def pause(self) -> float:
        """s without acceleration between a ramp up and a ramp down."""

class ParabolicSegment:
    """
    Ramps of n joints in one common time, with a cruise in between.

    Each joint ramps to a speed of its own, keeps it, and ramps to its final speed. All joints start and end together
    and are otherwise independent, so only the slowest one needs its limits; the others have time to spare (Hauser and
    Ng-Thow-Hing 2010, with the speeds of all joints free at both ends). Ramps begin and end on ticks, so a filtered
    motion never switches between two ticks.
    """

    def __init__(self, q0: numpy.typing.NDArray[numpy.float64], v0: numpy.typing.NDArray[numpy.float64], speed: numpy.typing.NDArray[numpy.float64], v1: numpy.typing.NDArray[numpy.float64], up: numpy.typing.NDArray[numpy.float64], down: numpy.typing.NDArray[numpy.float64], duration: float) -> None:
        """
        Make a segment.

        Args:
            q0: (n,) positions at the start, rad or m.
            v0: (n,) velocities at the start.
            speed: (n,) velocities of the cruise.
            v1: (n,) velocities at the end.
            up: (n,) s from the start, in which the velocity changes from v0 to speed.
            down: (n,) s before the end, in which the velocity changes from speed to v1.
            duration: s.
        """

    @property
    def q0(self) -> numpy.typing.NDArray[numpy.float64]:
        """(n,) positions at the start."""

    @property
    def speed(self) -> numpy.typing.NDArray[numpy.float64]:
        """(n,) velocities of the cruise."""

    @property
    def up(self) -> numpy.typing.NDArray[numpy.float64]:
        """(n,) s of the first ramp, from the start."""

    @property
    def down(self) -> numpy.typing.NDArray[numpy.float64]:
        """(n,) s of the last ramp, before the end."""

    @property
    def duration(self) -> float:
        """s."""

    def evaluate(self, t: numpy.typing.NDArray[numpy.float64]) -> tuple[numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64]]:
        """Positions and velocities (M, n) at t (M,), s since the segment began."""

    def state(self, t: float) -> JointState:
        """Positions and velocities at t s since the segment began."""

    def part(self, start: float, end: float) -> ParabolicSegment:
        """The segment between two times, s since it began."""

class ParabolicTrajectory:
    """
    Parabolic segments, each beginning as the one before it ends; at rest at both ends.

    Accelerations jump between the segments and inside them; filter_jerk makes a trajectory with limited jerk of it.
    """

    def __init__(self, segments: Sequence[ParabolicSegment]) -> None:
        """Join segments, in their order."""

    @property
    def segments(self) -> list[ParabolicSegment]:
        """The segments, in their order."""

    @property
    def duration(self) -> float:
        """s from rest to rest, before jerk is limited."""

    def total(self, limits: ParabolicLimits) -> float:
        """Duration once the jerk limits are kept, s: with the jerk window."""

    def state(self, t: float) -> JointState:
        """Positions and velocities at t s since the start."""

    def between(self, start: float, end: float) -> list[ParabolicSegment]:
        """
        The segments between two times, cut where the times fall into them.

        Args:
            start: s since the start, on a tick.
            end: s since the start, on a tick.
        """

    def replaced(self, start: float, end: float, segments: Sequence[ParabolicSegment]) -> ParabolicTrajectory:
        """
        The trajectory with other segments between two times.

        Args:
            start: s since the start, on a tick.
            end: s since the start, on a tick.
            segments: Segments that lead from the state at start to the state at end.
        """

def steer_min_time(start: JointState, end: JointState, limits: ParabolicLimits, at_most: float) -> ParabolicSegment | None:
    """
    The segment of least time between two states, without regard to obstacles.

    Args:
        start: State in which it begins.
        end: State in which it ends.
        limits: Velocity and acceleration limits, and the pause.
        at_most: Longest duration that is wanted, s.

    Returns:
        The segment; None if it takes longer than at_most, or if a joint has no segment of any of the times tried.
    """

def steer_fixed_time(start: JointState, end: JointState, limits: ParabolicLimits, duration: float) -> ParabolicSegment | None:
    """
    The segment of a given duration between two states.

    Args:
        start: State in which it begins.
        end: State in which it ends.
        limits: Velocity and acceleration limits, and the pause.
        duration: s, a whole number of ticks.

    Returns:
        The segment, or None if a joint has none of that duration.
    """

def steer_via(start: JointState, middles: Sequence[JointState], end: JointState, limits: ParabolicLimits, there: float, back: float) -> tuple[ParabolicSegment, ParabolicSegment] | None:
    """
    Two segments by way of a state in between, which every joint chooses on its own.

    Every joint takes the first of the middle states for which it has both segments.

    Args:
        start: State in which the first segment begins.
        middles: States to choose from, the preferred first.
        end: State in which the second segment ends.
        limits: Velocity and acceleration limits, and the pause.
        there: Duration of the first segment, s.
        back: Duration of the second segment, s.

    Returns:
        Both segments, or None if a joint has no choice.
    """

def tube(segments: Sequence[ParabolicSegment], step: float) -> tuple[numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64]]:
    """
    Chords of segments, and how far the segments leave them.

    A curve of acceleration a leaves a chord of h s by a h^2 / 8 at most.

    Args:
        segments: Segments, one after the other.
        step: Longest chord, s.

    Returns:
        Chord ends (K, n) and slack (K - 1, n): on each chord the motion stays within the slack, joint by joint.
    """

def parabolic_positions(segments: Sequence[ParabolicSegment], t: numpy.typing.NDArray[numpy.float64]) -> numpy.typing.NDArray[numpy.float64]:
    """
    Positions (M, n) on segments, one after the other, at increasing t (M,), s since the first began.
    """

def parabolic_accelerations(segments: Sequence[ParabolicSegment]) -> numpy.typing.NDArray[numpy.float64]:
    """
    Accelerations (K, n) on segments, one after the other, a row for each of K ticks.
    """

def jerk_window(segments: Sequence[ParabolicSegment], limits: ParabolicLimits) -> float:
    """
    Time over which segments must be averaged to keep the jerk limits: a pause, or up to two.

    The jerk of an average over w s is the change of acceleration in w s, over w. Over two pauses it keeps the limit
    whatever the segments do; over one, unless a joint turns from ramp to ramp.

    Args:
        segments: Segments, one after the other.
        limits: Acceleration and jerk limits, and the pause.

    Returns:
        s, a whole number of ticks.
    """

class PriorityLevel:
    """Rows lower <= A x <= upper of one priority."""

    def __init__(self, rows: numpy.typing.NDArray[numpy.float64], lower: numpy.typing.NDArray[numpy.float64], upper: numpy.typing.NDArray[numpy.float64]) -> None:
        """
        Make a level.

        Args:
            rows: (m, n).
            lower: (m,) lower bounds; -1e300 and less are none.
            upper: (m,) upper bounds; 1e300 and more are none. Rows with two equal bounds are equalities.
        """

class HierarchySolution:
    """What a hierarchy of levels has in common."""

    @property
    def x(self) -> numpy.typing.NDArray[numpy.float64]:
        """(n,) the solution."""

    @property
    def violations(self) -> list[numpy.typing.NDArray[numpy.float64]]:
        """
        Of each level (m,), how far rows are above their upper bounds, or, negative, below the lower ones.
        """

    @property
    def n_iterations(self) -> int:
        """Changes of the active sets of all levels."""

    @property
    def failure(self) -> str:
        """"" if it is solved, else which level is not, and why."""

def solve_hierarchy(levels: Sequence[PriorityLevel], start: numpy.typing.NDArray[numpy.float64]) -> HierarchySolution:
    """
    Minimize lexicographically the norms of the levels' violations, those of the first one first.

    Args:
        levels: Levels of strict priority, the most important one first.
        start: (n,) where the search begins; where the least norms do not determine x, it stays near.
    """

class SurfaceKind(enum.IntEnum):
    """What the palm of a tool is about, and its coordinates."""

    PLANE = 0
    """x, y, z."""

    CYLINDER = 1
    """Azimuth, height, distance from the axis."""

    SPHERE = 2
    """Azimuth, elevation, distance from the middle."""

def prove_pose_blocks(checker: Checker, surface: SurfaceKind, T_world_surface: numpy.typing.NDArray[numpy.float64], wanted: numpy.typing.NDArray[numpy.float64], R_nominal: numpy.typing.NDArray[numpy.float64], cone: float, centers: numpy.typing.NDArray[numpy.float64], radii: numpy.typing.NDArray[numpy.float64], frames: numpy.typing.NDArray[numpy.int32], low: numpy.typing.NDArray[numpy.float64], high: numpy.typing.NDArray[numpy.float64], margin: float, smallest: float, most_cells: int) -> numpy.typing.NDArray[numpy.int32]:
    """
    Prove a tool without its arm free at every pose of blocks of an envelope.

    Args:
        checker: Its world, and which solids each frame may touch.
        surface: What the palm is about.
        T_world_surface: (4, 4) frame of the surface, m.
        wanted: (3,) unit, in the world: the axis across the normal from which roll is measured.
        R_nominal: (3, 3) the tool in the frame of that axis and the approach.
        cone: rad, half of the opening of the approach's cone.
        centers: (S, 3) m, spheres of the tool in the frame of the palm.
        radii: (S,) m.
        frames: (S,) of each sphere.
        low: (M, 6) least coordinates of the surface, roll and rotation vector across the normal, in m and rad.
        high: (M, 6) the greatest ones.
        margin: m, kept from everything.
        smallest: m of clearance beyond the margin that is not looked for.
        most_cells: Into which a block is divided.

    Returns:
        (M,) 1 where a block is proven free, else 0.
    """

class ReferenceKind(enum.IntEnum):
    """From what a distance is measured."""

    PLANE = 0
    """A plane: signed, positive on the side of its normal."""

    LINE = 1
    """A line, e.g. the axis of a cylinder."""

    POINT = 2
    """A point, e.g. the centre of a sphere."""

class PoseConstraintKind(enum.IntEnum):
    """
    What a constraint on the pose of a tool bounds.

    d is the distance of the tool's origin from the reference, n the unit normal there, away from the reference.
    """

    DISTANCE_AT_MOST = 0
    """d - bound."""

    DISTANCE_AT_LEAST = 1
    """bound - d."""

    TOOL_TO_FIXED = 2
    """bound - (R tool) . fixed."""

    TOOL_TO_NORMAL = 3
    """bound - (R tool) . n."""

    NORMAL_TO_FIXED = 4
    """bound - n . fixed."""

class PoseConstraint:
    """An inequality e(T) <= 0 on the pose of a tool in an object's frame."""

    def __init__(self, kind: PoseConstraintKind, reference: ReferenceKind, origin: numpy.typing.NDArray[numpy.float64], axis: numpy.typing.NDArray[numpy.float64], tool: numpy.typing.NDArray[numpy.float64], fixed: numpy.typing.NDArray[numpy.float64], bound: float) -> None:
        """
        Make a constraint.

        Args:
            kind: What is bounded.
            reference: Kind of the reference.
            origin: (3,) m, a point of it in the object frame.
            axis: (3,) unit, normal of the plane or direction of the line; anything for a point.
            tool: (3,) unit, a direction in the tool frame.
            fixed: (3,) unit, a direction in the object frame.
            bound: m for distances, else the cosine of the largest angle.
        """

def pose_constraint_values(constraints: Sequence[PoseConstraint], T_object_tool: numpy.typing.NDArray[numpy.float64]) -> numpy.typing.NDArray[numpy.float64]:
    """
    Values of constraints at poses.

    Args:
        constraints: m of them.
        T_object_tool: (N, 4, 4).

    Returns:
        (N, m) m or cosines; a constraint is met where its value is not over 0.
    """

def pose_constraint_gradients(constraints: Sequence[PoseConstraint], T_object_tool: numpy.typing.NDArray[numpy.float64]) -> numpy.typing.NDArray[numpy.float64]:
    """
    Gradients of constraints at a pose.

    Args:
        constraints: m of them.
        T_object_tool: (4, 4).

    Returns:
        (m, 6) derivatives by the velocity of the tool's origin in m, and by its angular velocity in rad, both along
        the axes of the object frame.
    """

def project_to_constraints(constraints: Sequence[PoseConstraint], chain: Chain, T_last_tip: numpy.typing.NDArray[numpy.float64], T_world_object: numpy.typing.NDArray[numpy.float64], seeds: numpy.typing.NDArray[numpy.float64], reference: numpy.typing.NDArray[numpy.float64], lower: numpy.typing.NDArray[numpy.float64], upper: numpy.typing.NDArray[numpy.float64], weights: numpy.typing.NDArray[numpy.float64], max_iterations: int = 40) -> tuple[numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.int32]]:
    """
    Configurations near a reference whose tool poses meet all constraints, each by a descent from a seed.

    By a descent along the constraints, each step a hierarchical QP of limits, constraints and distance.
    Deterministic: the same arguments give the same bits.

    Args:
        constraints: What the pose of the tip in the object frame has to meet.
        chain: The arm.
        T_last_tip: (4, 4) pose of the tip in frame L-1, m.
        T_world_object: (4, 4), m.
        seeds: (K, n) where the descents begin, in rad or m.
        reference: (n,) to which the distance is measured.
        lower: (n,) limits that all configurations keep.
        upper: (n,) limits that all configurations keep.
        weights: (n,) > 0, cost of the squared distance of each joint.
        max_iterations: Of each descent.

    Returns:
        (K, n) the configurations, (K,) their weighted distances from the reference, and (K,) 1 where all
        constraints are met, else 0.
    """

class DepthNoise:
    """
    Coefficients of a depth sensor.

    The error of a depth z has the standard deviation constant + quadratic (z - from)^2 + disparity_error z^2 / (fx
    baseline). Where a surface is met at an angle t > oblique_from to its normal, oblique / sqrt(z) t^2 / (pi/2 - t)^2 is
    added. The first and the last are the terms of Nguyen, Izadi and Lovell 2012 for structured light, the third is that of
    stereo.
    """

    def __init__(self, *, least: float, greatest: float, incidence_from: float, incidence_to: float, constant: float = 0.0, quadratic: float = 0.0, from_depth: float = 0.0, oblique: float = 0.0, oblique_from: float = 0.0, baseline: float = 0.0, disparity_error: float = 0.0, disparity_step: float = 0.0, correlation: float = 0.0, lateral: float = 0.0, lateral_oblique: float = 0.0, mixes_edges: bool = False) -> None:
        """
        Take coefficients.

        Args:
            least: m > 0, the nearest depth that is measured.
            greatest: m, the farthest one.
            incidence_from: rad, angle to the normal up to which all comes back.
            incidence_to: rad, at most pi/2, from which on nothing does; linear in between.
            constant: m.
            quadratic: 1/m.
            from_depth: m.
            oblique: m^1.5.
            oblique_from: rad.
            baseline: m to the second eye, along the camera's x; what it does not see has no depth. 0 without one.
            disparity_error: px.
            disparity_step: px, in whole multiples of which disparities come; 0 for any.
            correlation: px, width of the Gaussian filter that makes errors of neighbours alike, 0.5 to 2; 0 for none.
            lateral: px, standard deviation by which edges are off along rows and columns.
            lateral_oblique: px, times t / (pi/2 - t), added to it.
            mixes_edges: Whether pixels at edges get depths between those of both surfaces, as by time of flight.

        Raises:
            ValueError: No sensor can have them.
        """

def philox4x32(counter: numpy.typing.NDArray[numpy.uint64], key: numpy.typing.NDArray[numpy.uint64]) -> numpy.typing.NDArray[numpy.uint64]:
    """
    The random words of noise: Philox4x32-10 of Salmon, Moraes, Dror and Shaw 2011.

    Args:
        counter: (4,) of 32 bits each.
        key: (2,) of 32 bits each.

    Returns:
        (4,) of 32 bits each.
    """

class Texture:
    """A picture on a face, with smaller copies for what is far away."""

    def __init__(self, picture: numpy.typing.NDArray[numpy.uint8]) -> None:
        """
        Take a picture.

        Args:
            picture: (height, width, 3) red, green, blue, rows from the top.
        """

class Looks:
    """How solids look."""

    def __init__(self, colours: numpy.typing.NDArray[numpy.float64], gloss: numpy.typing.NDArray[numpy.float64], face_textures: numpy.typing.NDArray[numpy.int32], textures: Sequence[Texture]) -> None:
        """
        Take colours and textures.

        The faces of boxes, and of the boxes around balls, are +x, -x, +y, -y, +z, -z; those of cylinders +z, -z, mantle. From
        outside, +z is up on all but +z and -z, where +y is; the mantle begins at +x and goes on towards +y. Convex pieces have
        no textures.

        Args:
            colours: (N, 3) red, green, blue, 0 to 255, of faces without a texture.
            gloss: (N,) of highlights, 0 to 1.
            face_textures: (N, 6) index of the texture of each face, -1 for none.
            textures: The textures.
        """

class Lighting:
    """Where light comes from."""

    def __init__(self, ambient: float, headlight: float, lamp: float, T_world_lamp: numpy.typing.NDArray[numpy.float64], background: numpy.typing.NDArray[numpy.float64]) -> None:
        """
        Take amounts of light, of which 1 makes a white surface white.

        Args:
            ambient: From everywhere; a quarter less from below than from above.
            headlight: Of a light at the camera, on a surface square to it 0.5 m away.
            lamp: Of a lamp, on a surface square to its light.
            T_world_lamp: (4, 4) pose of the lamp; it shines along its z and throws shadows within 45 degrees of that.
            background: (3,) red, green, blue, 0 to 255, where nothing is seen.
        """

class RaycastingScene:
    """
    Solids as a pinhole camera sees them.

    A ray is cast for every pixel inside of the part of the picture that a solid may fill: no mesh, no graphics driver, one
    thread, and the same bytes on every processor of a family. Depth is exact up to single precision.

    Cameras are OpenCV's: x to the right, y down, z along the optical axis, and the middle of pixel (u, v) is at u, v. A
    solid that the camera's centre is inside of is not seen, as it is the camera's own body; of any other one, only the
    surface before the camera is.
    """

    def __init__(self, T_world_solid: numpy.typing.NDArray[numpy.float64], half_extents: numpy.typing.NDArray[numpy.float64], kind: numpy.typing.NDArray[numpy.int32], planes: numpy.typing.NDArray[numpy.float64], n_planes: numpy.typing.NDArray[numpy.int32]) -> None:
        """
        Take solids.

        Args:
            T_world_solid: (N, 4, 4) poses.
            half_extents: (N, 3) m > 0; of a cylinder (r, r, half length), of a sphere (r, r, r).
            kind: (N,) of SolidKind.
            planes: (P, 4) by which boxes are cut to convex pieces: (normal, offset) of the half-space normal . p <= offset in
                the frame of the box, those of each box together, in the order of the solids.
            n_planes: (N,) how many of them cut each solid; 0 for cylinders and spheres.
        """

    def cast_rays(self, intrinsics: numpy.typing.NDArray[numpy.float64], size: numpy.typing.NDArray[numpy.int32], T_world_camera: numpy.typing.NDArray[numpy.float64]) -> tuple[numpy.typing.NDArray[numpy.float32], numpy.typing.NDArray[numpy.int32], numpy.typing.NDArray[numpy.float32]]:
        """
        See the solids.

        Args:
            intrinsics: (4,) fx, fy, cx, cy in px.
            size: (2,) width and height in px.
            T_world_camera: (4, 4) pose of the camera.

        Returns:
            Depth along the optical axis in m, (H, W), NaN where nothing is seen; the index of the solid, (H, W), -1 where
            nothing is seen; the outward normal of its surface in the camera's frame, (H, W, 3), NaN where nothing is seen.
        """

    def measured_depth(self, intrinsics: numpy.typing.NDArray[numpy.float64], size: numpy.typing.NDArray[numpy.int32], T_world_camera: numpy.typing.NDArray[numpy.float64], noise: DepthNoise, no_return: numpy.typing.NDArray[numpy.float64], seed: int) -> numpy.typing.NDArray[numpy.float32]:
        """
        See the solids as a depth sensor does.

        What a pixel draws depends on its place and the seed alone: equal seeds give equal bytes.

        Args:
            intrinsics: (4,) fx, fy, cx, cy in px.
            size: (2,) width and height in px.
            T_world_camera: (4, 4) pose of the camera.
            noise: Coefficients of the sensor.
            no_return: (N,) by solid, the share of blots of 4 x 4 px in which its material does not answer.
            seed: Of 64 bits.

        Returns:
            (H, W) depth along the optical axis in m, NaN where nothing comes back.
        """

    def shaded(self, intrinsics: numpy.typing.NDArray[numpy.float64], size: numpy.typing.NDArray[numpy.int32], T_world_camera: numpy.typing.NDArray[numpy.float64], looks: Looks, lighting: Lighting) -> numpy.typing.NDArray[numpy.uint8]:
        """
        See the solids in colour.

        Args:
            intrinsics: (4,) fx, fy, cx, cy in px.
            size: (2,) width and height in px.
            T_world_camera: (4, 4) pose of the camera.
            looks: How the solids look, in their order.
            lighting: Where light comes from.

        Returns:
            (H, W, 3) red, green, blue.
        """

def surface_distance(kind: int, half_extents: numpy.typing.NDArray[numpy.float64], points: numpy.typing.NDArray[numpy.float64]) -> tuple[numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64]]:
    """
    How far points are from the surface of a solid.

    Args:
        kind: A value of SolidKind.
        half_extents: (3,) m; of a cylinder (r, r, half length), of a sphere (r, r, r).
        points: (N, 3) in the solid's frame.

    Returns:
        Distances (N,) in m, negative inside, and their gradients (N, 3), of length 1.
    """

def fit_surface(kind: int, half_extents: numpy.typing.NDArray[numpy.float64], points: numpy.typing.NDArray[numpy.float64], start: numpy.typing.NDArray[numpy.float64], scale: float, up: numpy.typing.NDArray[numpy.float64] | None = None, most_steps: int = 50) -> tuple[numpy.typing.NDArray[numpy.float64], float, int]:
    """
    Fit the pose of a solid to points on its surface.

    Powell's dogleg (1970) on the mean of d^2 / (scale^2 + d^2) over the points (Geman and McClure 1985), of which d is the
    distance from the surface.

    Args:
        kind: A value of SolidKind.
        half_extents: (3,) m; of a cylinder (r, r, half length), of a sphere (r, r, r).
        points: (N, 3) m.
        start: (4, 4) pose to begin at.
        scale: m from which on a point counts as one of something else.
        up: (3,) the only axis of turns, of length 1; None for turns about all axes.
        most_steps: Number of steps at most.

    Returns:
        The pose (4, 4), the cost in [0, 1), and the number of steps.
    """

class PlacePicture:
    """
    A picture of one place, and how well items in it explain the picture.

    Render and compare: for every pixel in which an item would be seen, the costs (negative logarithms of likelihoods) of
    what was measured there tell whether its surface was measured (and how far off), was seen through, is behind something
    else, or gave no depth, and whether the colour is one of its own. All poses are in the camera's frame. Items hide each
    other. One thread; the same input gives the same bytes.
    """

    def __init__(self, intrinsics: numpy.typing.NDArray[numpy.float64], depth: numpy.typing.NDArray[numpy.float32], share: numpy.typing.NDArray[numpy.float32], colour: numpy.typing.NDArray[numpy.int32], known: Sequence[numpy.typing.NDArray[numpy.float32]], known_solids: tuple[numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.int32]], known_colours: numpy.typing.NDArray[numpy.float64], noise: DepthNoise, costs: numpy.typing.NDArray[numpy.float64]) -> None:
        """
        Take a picture, of which each pixel may stand for a block of the sensor's.

        Args:
            intrinsics: (4,) fx, fy, cx, cy in px.
            depth: (H, W) m along the optical axis; anything where nothing was measured.
            share: (H, W) share of each block that was measured.
            colour: (H, W) labels of colours.
            known: Depth (H, W) in m of what is known, NaN where items are not looked for, and (H, W) the cosine between ray and
                normal there.
            known_solids: Poses (K, 4, 4), half extents (K, 3) and kinds (K,) of solids that items do not reach into.
            known_colours: (L,) cost of each label on what is known.
            noise: Coefficients of the sensor.
            costs: (6,) m that surfaces may be off besides noise; the most that a depth before, and one behind what is expected
                cost; the share of pixels without depth whatever the surface; the most that no depth costs where the second eye
                sees something else, or the surface is out of the sensor's range; the weight of a pixel.
        """

    def add(self, kind: int, half_extents: numpy.typing.NDArray[numpy.float64], no_return: float, colours: numpy.typing.NDArray[numpy.float64]) -> int:
        """
        Add an item that may be in the place.

        Args:
            kind: A value of SolidKind.
            half_extents: (3,) m; of a cylinder (r, r, half length), of a sphere (r, r, r).
            no_return: Share of its surface from which nothing comes back.
            colours: (L,) cost of each label on it.

        Returns:
            Its index.
        """

    def candidates(self, product: int, starts: numpy.typing.NDArray[numpy.float64], up: numpy.typing.NDArray[numpy.float64], steps: numpy.typing.NDArray[numpy.float64], counts: tuple[int, int], placed: tuple[numpy.typing.NDArray[numpy.int32], numpy.typing.NDArray[numpy.float64]]) -> tuple[numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64]]:
        """
        Find the best places of one item.

        Each start is fitted to the points near it that nothing explains; the best are moved while that explains the picture
        better, and of those at most a few are kept around each place.

        Args:
            product: Index of the item.
            starts: (N, 4, 4) poses.
            up: (3,) against gravity; moved items are turned about it.
            steps: (S,) m, sizes of the moves, falling.
            counts: How many starts are moved, and how many places are kept.
            placed: Indices (M,) and poses (M, 4, 4) of other items that are there.

        Returns:
            Poses (K, 4, 4), the best first, and gains (K,): by how much the picture is explained better.
        """

    def choose(self, products: numpy.typing.NDArray[numpy.int32], options: Sequence[numpy.typing.NDArray[numpy.float64]], least_gain: float) -> tuple[numpy.typing.NDArray[numpy.int32], numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64]]:
        """
        Choose a pose for each of several items, or none, so that together they explain the picture best.

        Greedily at first, then items one by one and in pairs while that gets better. Items that reach into each other, or into
        what is known, cost.

        Args:
            products: (N,) indices of the items.
            options: Poses (K, 4, 4) of each.
            least_gain: By which an item must explain the picture better to be placed.

        Returns:
            Indices (N,) of the options, -1 for none; the gain (N,) of each, with the others in their places; and its margin
            (N,): the gain beside that of the item's best option elsewhere.
        """

    def refined(self, products: numpy.typing.NDArray[numpy.int32], T_camera_item: numpy.typing.NDArray[numpy.float64], up: numpy.typing.NDArray[numpy.float64] | None, steps: numpy.typing.NDArray[numpy.float64], allowed_penetration: float, n_rounds: int) -> numpy.typing.NDArray[numpy.float64]:
        """
        Move placed items, one after the other, while that explains the picture better.

        Args:
            products: (N,) indices of the items.
            T_camera_item: (N, 4, 4) their poses.
            up: (3,) the only axis of turns, then boxes are also tried with exchanged axes; None for turns about all axes.
            steps: (S,) m, sizes of the moves, falling.
            allowed_penetration: m that items may reach into each other and into what is known.
            n_rounds: How often each is moved.

        Returns:
            (N, 4, 4) poses.
        """

    def evidence(self, products: numpy.typing.NDArray[numpy.int32], T_camera_item: numpy.typing.NDArray[numpy.float64], near_surface: float) -> numpy.typing.NDArray[numpy.float64]:
        """
        Tell what the picture says of placed items.

        Args:
            products: (N,) indices of the items.
            T_camera_item: (N, 4, 4) their poses.
            near_surface: m within which a surface was measured.

        Returns:
            (N, 7) pixels that would show it if nothing but what is known were before it; of these those that no other item
            hides; of these those in which its surface, something behind it, and something before it was measured; the gain by
            which the picture is explained better with it than without; the mean cost of the colours of supported pixels.
        """

    def costs(self, product: int, T_camera_item: numpy.typing.NDArray[numpy.float64], placed: tuple[numpy.typing.NDArray[numpy.int32], numpy.typing.NDArray[numpy.float64]]) -> numpy.typing.NDArray[numpy.float64]:
        """
        Tell what an item costs at several poses, beside what it hides there.

        Args:
            product: Index of the item.
            T_camera_item: (N, 4, 4) poses.
            placed: Indices (M,) and poses (M, 4, 4) of other items that are there.

        Returns:
            (N,) costs of the picture with the item, less that without it; penetrations cost nothing here.
        """

    def composed(self, products: numpy.typing.NDArray[numpy.int32], T_camera_item: numpy.typing.NDArray[numpy.float64]) -> tuple[numpy.typing.NDArray[numpy.int32], numpy.typing.NDArray[numpy.float32], numpy.typing.NDArray[numpy.float32]]:
        """
        Render placed items before what is known.

        Args:
            products: (N,) indices of the items.
            T_camera_item: (N, 4, 4) their poses.

        Returns:
            (H, W) which of the items is seen, -1 for what is known; depth (H, W) in m, infinite where nothing is looked for;
            cost (H, W) of each pixel.
        """

def simd() -> str:
    """
    Which build of the batch test and of the rays runs: "avx2" or "baseline". Both give the same bits.
    """

def set_simd(name: str) -> None:
    """
    Choose the build of the batch test and of the rays, "avx2" or "baseline".

    Raises:
        ValueError: This processor does not have it.
    """
