"""Types and meaning of the native module. Wrong shapes and values raise ValueError naming the argument.

Any array-like goes in; C-contiguous arrays of the named dtype are read in place. Angles in rad, lengths
in m. ``n`` is the length of a configuration, ``L`` the number of frames.
"""

from numpy import bool_, float64, int32, uint64
from numpy.typing import NDArray

class Chain:
    """A serial chain: at most 63 joints, of which at most 32 entries of q move any."""

    def __init__(
        self,
        joint_types: NDArray[int32],
        T_parent_joint: NDArray[float64],
        axes: NDArray[float64],
        q_index: NDArray[int32],
    ) -> None:
        """Make a chain from the base outwards.

        joint_types: (L,), 0 revolute or continuous, 1 prismatic, 2 fixed
        T_parent_joint: (L, 4, 4) pose of the joint frame in frame k-1 (k = 0: in the world) at position 0
        axes: (L, 3) in the joint frame, normalised here; ignored for fixed joints
        q_index: (L,) entry of q that moves the joint, -1 for fixed ones; every entry 0..n-1 is used
        """

    @property
    def n(self) -> int:
        """Length of a configuration."""

    @property
    def n_frames(self) -> int:
        """Number of frames L."""

    def fk(self, q: NDArray[float64]) -> NDArray[float64]:
        """Poses (L, 4, 4) of all frames in the world at q (n,)."""

    def fk_batch(self, Q: NDArray[float64]) -> NDArray[float64]:
        """Poses (N, L, 4, 4) of all frames at each of the configurations Q (N, n)."""

    def jacobian(self, q: NDArray[float64], T_last_tip: NDArray[float64]) -> NDArray[float64]:
        """Jacobian (6, n) of the tip, given as a pose (4, 4) in frame L-1: linear x y z, then angular
        x y z, both along the axes of the world."""

    def tip_motion(
        self,
        Q: NDArray[float64],
        dQ: NDArray[float64],
        ddQ: NDArray[float64],
        T_last_tip: NDArray[float64],
    ) -> tuple[NDArray[float64], NDArray[float64]]:
        """Poses (N, 4, 4) and motion (N, 4, 3) of the tip at configurations Q (N, n), world axes.

        The rows of a motion are velocity, angular velocity, acceleration and angular acceleration, for the
        joints' first and second derivatives dQ and ddQ (N, n), by time or by a path's parameter.
        """

    def ik(
        self,
        T_world_target: NDArray[float64],
        T_last_tip: NDArray[float64],
        seeds: NDArray[float64],
        lower: NDArray[float64],
        upper: NDArray[float64],
        weights: NDArray[float64],
        max_iterations: int = 60,
        position_tolerance: float = 1e-5,
        rotation_tolerance: float = 1e-4,
        distinct: float = 0.05,
    ) -> NDArray[float64]:
        """Configurations (M, n) that bring the tip to T_world_target.

        Damped least squares (Levenberg-Marquardt) from each of the seeds (K, n). All solutions lie within
        lower..upper (n,) and within both tolerances (m, rad), and stand in the order of their seeds; one
        that is within ``distinct`` of an earlier one in every joint is left out. A joint with a larger
        weight (n,) moves less. Deterministic.
        """

    def follow(
        self,
        T_world_targets: NDArray[float64],
        T_last_tip: NDArray[float64],
        q0: NDArray[float64],
        lower: NDArray[float64],
        upper: NDArray[float64],
        weights: NDArray[float64],
        max_step: NDArray[float64],
    ) -> tuple[NDArray[float64], int]:
        """Follow poses (P, 4, 4) from q0 (n,), each solved from the solution before it.

        Returns the configurations (n_done, n) of the first n_done poses and why it ended: 0 all done,
        1 no convergence, 2 a joint would step over max_step (n,) (from q0 to the first, too), 3 no
        convergence with a joint pressed against a limit.
        """

class EdgeReport:
    """Whether an edge is free, and if not, where and why."""

    @property
    def free(self) -> bool:
        """Whether every point of the edge is proven free."""

    @property
    def t(self) -> float:
        """Where on the edge, 0 at q0 and 1 at q1, it was found not free; -1 if it is."""

    @property
    def frame(self) -> int:
        """The frame that is not free there, L for the held item; -1 if the edge is free."""

    @property
    def kind(self) -> int:
        """What it meets: 0 a solid of the world, 1 another frame; -1 if the edge is free."""

    @property
    def index(self) -> int:
        """Index of the solid, or the frame nearer to the base; -1 if the edge is free."""

    @property
    def n_configurations(self) -> int:
        """How many configurations were tested."""

class Checker:
    """Collision checks of a chain whose frames carry spheres, in a world of boxes, cylinders and spheres.

    A solid is given by the pose and the half extents of its box (kind 0); those of a cylinder (kind 1), which
    is about its z, are (radius, radius, half length), those of a sphere (kind 2) three times its radius. Its
    rounding in m adds every point within that distance.

    Checks may run in several threads; set_world and set_held must not run meanwhile.
    """

    def __init__(
        self,
        chain: Chain,
        centers: NDArray[float64],
        radii: NDArray[float64],
        frame: NDArray[int32],
        self_pairs: NDArray[int32],
    ) -> None:
        """Spheres: centers (S, 3) in their frames, radii (S,), frame (S,) in 0..L-1. self_pairs (P, 2):
        the pairs of frames that must stay clear of each other."""

    @property
    def rounding(self) -> float:
        """Bound in m on what is_free, are_free and edges add to the margin for single precision (with at
        most 1 m of prismatic travel; it grows with travel)."""

    def set_world(
        self,
        T_world_box: NDArray[float64],
        half_extents: NDArray[float64],
        group: NDArray[int32],
        ignored_frames: NDArray[uint64],
        kind: NDArray[int32] | None = None,
        rounding: NDArray[float64] | None = None,
    ) -> None:
        """Replace the world by solids: poses (B, 4, 4), half extents (B, 3), group (B,) of those that stand
        close together, ignored_frames (B,): bit f set, frame f is never tested against the solid; bit L is
        the held item. kind and rounding (B,): all are boxes, and none is rounded, unless given."""

    def set_held(
        self,
        centers: NDArray[float64],
        radii: NDArray[float64],
        tested_frames: NDArray[int32],
    ) -> None:
        """Replace the held item: spheres (H, 3), (H,) rigid in frame L-1, and the frames they must stay
        clear of. Empty arrays: nothing is held."""

    def set_held_solid(
        self,
        T_last_solid: NDArray[float64],
        half_extents: NDArray[float64],
        tested_frames: NDArray[int32],
        kind: int = 0,
        rounding: float = 0.0,
    ) -> None:
        """Replace the held item by one solid in frame L-1: pose (4, 4), half extents (3,).

        Its distance from the frames is exact. That from the world is judged by the widest slab between the
        two that a few directions give: never too large, and too small by a few per mille at most.
        """

    def is_free(self, q: NDArray[float64], margin: float = 0.0) -> bool:
        """Whether everything at q (n,) keeps more than margin."""

    def are_free(self, Q: NDArray[float64], margin: float = 0.0) -> NDArray[bool_]:
        """is_free of each of Q (N, n), as (N,)."""

    def edge_is_free(
        self,
        q0: NDArray[float64],
        q1: NDArray[float64],
        margin: float = 0.0,
        slack: NDArray[float64] | None = None,
        resolution: float = 2e-4,
    ) -> bool:
        """Whether every configuration on the straight segment from q0 to q1 (n,), and within slack (n,) of
        it in each joint, is proven to keep more than margin.

        True is a proof. False means that some point of it comes closer than margin plus what slack moves
        it plus resolution (m), where splitting the edge further ends.
        """

    def path_is_free(
        self,
        Q: NDArray[float64],
        margin: float = 0.0,
        slack: NDArray[float64] | None = None,
        resolution: float = 2e-4,
    ) -> int:
        """Index of the first edge of the polyline Q (N, n) that is not proven free, -1 if all are.
        slack: (N-1, n), by edge. A single configuration counts as an edge of no length."""

    def check_edge(
        self,
        q0: NDArray[float64],
        q1: NDArray[float64],
        margin: float = 0.0,
        slack: NDArray[float64] | None = None,
        resolution: float = 2e-4,
    ) -> EdgeReport:
        """edge_is_free with the reason."""

    def clearance(self, q: NDArray[float64], max_distance: float = 1.0) -> tuple[float, int, int, int]:
        """Signed distance of the nearest pair at q (n,) in double precision, with frame, kind and index as
        in EdgeReport. (max_distance, -1, -1, -1) if nothing is nearer. Against a box it is negative by
        the depth of the sphere below the nearest face."""

    def clearances(self, Q: NDArray[float64], max_distance: float = 1.0) -> NDArray[float64]:
        """The distance of clearance for each of Q (N, n), as (N,)."""

def fastest_pace(
    s: NDArray[float64],
    dq: NDArray[float64],
    ddq: NDArray[float64],
    acceleration: NDArray[float64],
    speed: NDArray[float64],
    line_speed: NDArray[float64],
    is_line: NDArray[int32],
    cruise: float = 0.0,
) -> tuple[NDArray[float64], NDArray[float64], NDArray[float64]]:
    """Time-optimal motion from rest to rest along a path, by TOPP-RA: t, s, ds/dt, each (P,); ds/dt is
    linear in t between the points.

    The path is given at gridpoints s (M,), increasing: dq/ds and its derivative ddq (M, n), limits of
    ds/dt speed (M,), of joint acceleration (M-1, n) > 0 by interval. On an interval with is_line (M-1,)
    nothing bends: its profile is exact, never faster than line_speed (M-1,), and cruises ``cruise`` s at
    least.
    """

def quintic_peaks(
    times: NDArray[float64],
    positions: NDArray[float64],
    velocities: NDArray[float64],
    accelerations: NDArray[float64],
) -> tuple[NDArray[float64], NDArray[float64], NDArray[float64]]:
    """Largest |velocity| (an upper bound), |acceleration| and |jerk| (both exact), each (N-1, n), on the
    quintics between N points with increasing times (N,) and states (N, n)."""

def rrt_connect(
    checker: Checker,
    start: NDArray[float64],
    goals: NDArray[float64],
    lower: NDArray[float64],
    upper: NDArray[float64],
    seed: int,
    max_iterations: int,
    step: float,
    margin: float = 0.0,
    resolution: float = 2e-4,
) -> NDArray[float64]:
    """Waypoints (K, n) from start (n,) to one of the goals (G, n) by RRT-Connect; (0, n) if none was found.

    Kuffner and LaValle 2000, but the smaller tree grows. Configurations are drawn between lower and upper
    (n,); step: longest edge of a tree, Euclidean in joint space, 1e-6 at least. Every edge is proven as by
    edge_is_free; start and goals are not asked about. Same arguments, same bytes.
    """

def shorten(
    checker: Checker,
    Q: NDArray[float64],
    shortcuts: NDArray[float64],
    velocity: NDArray[float64],
    calm: float,
    worthwhile: float,
    margin: float = 0.0,
    resolution: float = 2e-4,
) -> NDArray[float64]:
    """A polyline (K, n) with the ends of Q (N, n) that costs no more; every new edge is proven as by
    edge_is_free, those of Q are taken to be.

    An edge dq costs the largest |dq_j| / velocity_j, velocity (n,) > 0, and calm times the length of
    dq / velocity. Vertices that a proven edge skips go. Then the shortcuts (S, 2) are tried in their order:
    each joins the points at two increasing shares of the cost of the polyline as it is then, and is taken if
    it saves ``worthwhile`` times that cost (Geraerts and Overmars 2007). Then vertices go again.
    """

def simd() -> str:
    """Which build of the hot test runs: "avx2" or "baseline". Both give the same bits."""

def set_simd(name: str) -> None:
    """Choose the build. Raises ValueError for one that this processor does not have."""
