"""Warnings for valid but implausible values in a scene file, which the file can accept."""

from __future__ import annotations

from pickcli.files.file_warnings import FileWarnings
from pickcli.scene.scene import PoseNoise, Scene

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
    stated: list[tuple[str, PoseNoise | None, tuple[str | int, ...]]] = [("every item", scene.noise, ())]
    stated += [(placed.id, placed.noise, ("items", i)) for i, placed in enumerate(scene.items)]
    for what, noise, key in stated:
        subject = "" if not key else f"{what}."
        if noise is not None and noise.position > VAGUE:
            text = f"{what} counts as {1e3 * noise.position:g} mm larger all around; is it in m?"
            warnings.add("large_noise", f"{subject}position", (*key, "noise", "position"), text)
        if noise is not None and noise.angle > LARGE_ANGLE_NOISE:
            text = f"{what} may be turned by {noise.angle:g} rad either way; is it in rad, not degrees?"
            warnings.add("large_noise", f"{subject}angle", (*key, "noise", "angle"), text)
