"""Warnings for cameras whose figures are valid but implausible, as in other units."""

from __future__ import annotations

import math

from pickcli.cell.cell import Cell
from pickcli.files.file_warnings import FileWarnings

NARROW_VIEW, WIDE_VIEW = 1.0, 170.0  # degrees, of a picture without distortion
FAR_OFF, TURNED_OFF = 0.02, 0.05  # m and rad, several times a bad hand-eye calibration


def warn_of_cameras(warnings: FileWarnings, cell: Cell) -> None:
    """Warn of fields of view that no lens has, and of errors of poses with which nothing is found.

    Args:
        warnings: Collects them.
        cell: The cell.
    """
    for name, camera in cell.cameras.items():
        picture, sensor = camera.model.camera, ("sensors", name)
        for key, focal, size in (("fx", picture.fx, picture.width), ("fy", picture.fy, picture.height)):
            degrees = 2.0 * math.degrees(math.atan(size / (2.0 * focal)))
            if not NARROW_VIEW <= degrees <= WIDE_VIEW:
                text = (
                    f"with {key} {focal:g} and {size} px {camera.model.name} sees {degrees:.3g} degrees; is "
                    f"its {key} in px, not mm?"
                )
                warnings.add("odd_camera", f"{name}.{key}", (*sensor, "model"), text)
        if camera.error.position > FAR_OFF:
            text = f"its pose may be off by {1e3 * camera.error.position:g} mm; is it in m?"
            warnings.add("odd_camera", f"{name}.position", (*sensor, "error", "position"), text)
        if camera.error.angle > TURNED_OFF:
            off = math.degrees(camera.error.angle)
            text = f"its pose may be turned by {off:.1f} degrees; is it in rad, not degrees?"
            warnings.add("odd_camera", f"{name}.angle", (*sensor, "error", "angle"), text)
