"""Warnings for valid but implausible values in a scene file, which the file can accept."""

from __future__ import annotations

from pickcli.files.file_warnings import FileWarnings
from pickcli.scene.scene import Scene

NOT_AT_REST = "not_at_rest"
WARNINGS = ("large_noise", NOT_AT_REST)  # kinds of warnings about scene files
VAGUE = 0.02  # m, rounded up from the error of cameras above a shelf
LARGE_ANGLE_NOISE = 0.2  # rad, pose noise beyond which it is reported


def warn_of_noise(warnings: FileWarnings, scene: Scene) -> None:
    """Warn of pose errors so large that hardly anything can be picked.

    Args:
        warnings: Collects them.
        scene: The scene.
    """
    if scene.noise.position > VAGUE:
        text = f"every item counts as {1e3 * scene.noise.position:g} mm larger all around; is it in m?"
        warnings.add("large_noise", "position", ("noise", "position"), text)
    if scene.noise.angle > LARGE_ANGLE_NOISE:
        text = f"every item may be turned by {scene.noise.angle:g} rad either way; is it in rad, not degrees?"
        warnings.add("large_noise", "angle", ("noise", "angle"), text)
