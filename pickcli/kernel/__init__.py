"""The one native module: kinematics, inverse kinematics, clearance and proven edges of a serial chain.

Everything here works on plain float64 arrays in SI units and knows nothing of cells or items. Frame k of
a chain is the child link of joint k; the parent of joint k is frame k-1, that of joint 0 the world.
"""

from pickcli.kernel._kernel import Chain, Checker, EdgeReport, set_simd, simd

__all__ = ["Chain", "Checker", "EdgeReport", "set_simd", "simd"]
