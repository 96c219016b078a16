"""The one native module: kinematics, clearance and proven edges of a serial chain; paces along paths.

Everything here works on plain float64 arrays in SI units and knows nothing of cells or items. Frame k of
a chain is the child link of joint k; the parent of joint k is frame k-1, that of joint 0 the world.
"""

from pickcli.kernel._kernel import (
    BlendedPolyline,
    Chain,
    Checker,
    ContactKind,
    EdgeReport,
    FollowEnd,
    JointKind,
    SolidKind,
    estimated_duration,
    fastest_pace,
    line_deviation,
    quintic_peaks,
    quintic_states,
    rrt_connect,
    set_simd,
    shorten,
    simd,
    smoothed_pace,
)

__all__ = [
    "BlendedPolyline",
    "Chain",
    "Checker",
    "ContactKind",
    "EdgeReport",
    "FollowEnd",
    "JointKind",
    "SolidKind",
    "estimated_duration",
    "fastest_pace",
    "line_deviation",
    "quintic_peaks",
    "quintic_states",
    "rrt_connect",
    "set_simd",
    "shorten",
    "simd",
    "smoothed_pace",
]
