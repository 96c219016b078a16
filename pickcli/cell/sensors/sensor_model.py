"""Models of cameras: intrinsics, and for depth the coefficients of its noise."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from pickcli.cell.sensors.material import Material
from pickcli.cell.sensors.pinhole_camera import PinholeCamera
from pickcli.geometry import Array


@dataclass(frozen=True)
class DepthModel:
    """How a sensor measures depth.

    The error of a depth z has the standard deviation constant + quadratic (z - from_depth)^2 +
    disparity_error z^2 / (fx baseline). Where a surface is met at an angle t > oblique_from to its normal,
    oblique / sqrt(z) t^2 / (pi/2 - t)^2 is added (Nguyen, Izadi and Lovell 2012).

    Attributes:
        least: m, nearest depth that is measured.
        greatest: m, farthest depth that is measured.
        incidence_from: rad, angle to the normal up to which everything comes back.
        incidence_to: rad, angle from which on nothing comes back; the share is linear in between.
        constant: m.
        quadratic: 1/m.
        from_depth: m.
        oblique: m^1.5.
        oblique_from: rad.
        baseline: m to the second eye, or to the projector, along the camera's x; what it does not see has no
            depth. 0 for a sensor with one eye.
        disparity_error: px.
        disparity_step: px, in whole multiples of which disparities are measured; 0 for any.
        correlation: px, width of the Gaussian filter that makes errors of neighbours alike; 0 for none.
        lateral: px by which edges are off along rows and columns, standard deviation.
        lateral_oblique: px, times t / (pi/2 - t), added to it.
        mixes_edges: Whether pixels at edges get depths between both surfaces, as by time of flight.
        no_return: By material, the share of a surface from which nothing comes back, in blots; 0 for all
            others.
    """

    least: float
    greatest: float
    incidence_from: float
    incidence_to: float
    constant: float
    quadratic: float
    from_depth: float
    oblique: float
    oblique_from: float
    baseline: float
    disparity_error: float
    disparity_step: float
    correlation: float
    lateral: float
    lateral_oblique: float
    mixes_edges: bool
    no_return: Mapping[Material, float]

    def spread(self, depth: Array, fx: float) -> Array:
        """Compute the standard deviation of depths of surfaces that face the sensor.

        Args:
            depth: m, of any shape.
            fx: px, focal length along a row.

        Returns:
            m, rounding to steps of disparity included.
        """
        per_pixel = depth**2 / (fx * self.baseline) if self.baseline else np.zeros_like(depth)
        noise = self.constant + self.quadratic * (depth - self.from_depth) ** 2
        noise = noise + self.disparity_error * per_pixel
        return np.asarray(np.hypot(noise, self.disparity_step * per_pixel / np.sqrt(12.0)))

    def step(self, depth: float, fx: float) -> float:
        """Compute the step of depths to whose multiples it is rounded.

        Args:
            depth: m.
            fx: px, focal length along a row.

        Returns:
            m; 0 if it is not rounded.
        """
        return self.disparity_step * depth**2 / (fx * self.baseline) if self.disparity_step else 0.0


@dataclass(frozen=True)
class SensorModel:
    """A camera as a product.

    Attributes:
        name: Name of the model.
        camera: Intrinsics.
        depth: How it measures depth; None for a colour camera.
        sources: Source of the figures, by key of the file.
    """

    name: str
    camera: PinholeCamera
    depth: DepthModel | None
    sources: Mapping[str, str]
