"""SIFT features of a picture (Lowe 2004), compared as Arandjelovic and Zisserman (2012) do (RootSIFT)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pickcli.geometry import Array
from pickcli.perception.procedural_texture import ColourPicture
from pickcli.perception.surface_view import FloatPicture
from pickcli.perception.textures.opencv import cv2

_CONTRAST = 0.02  # least contrast of a feature; half of Lowe's, as prints in a dark bin have little


@dataclass(frozen=True, eq=False)
class PrintFeatures:
    """Features of a picture.

    Attributes:
        pixels: (N, 2) column and row, px.
        sizes: (N,) px, diameters of what is described.
        angles: (N,) rad, direction from that of rows to that of columns.
        descriptors: (N, 128) float32 of length 1: the more alike two are, the larger is their product.
    """

    pixels: Array
    sizes: Array
    angles: Array
    descriptors: FloatPicture

    def __len__(self) -> int:
        return len(self.pixels)

    def only(self, kept: NDArray[np.bool_] | NDArray[np.intp]) -> PrintFeatures:
        """Keep some of the features.

        Args:
            kept: (N,) which ones, or (K,) their indices.

        Returns:
            These features.
        """
        return PrintFeatures(self.pixels[kept], self.sizes[kept], self.angles[kept], self.descriptors[kept])


N_VALUES = 128  # of a descriptor
NO_FEATURES = PrintFeatures(
    np.zeros((0, 2)), np.zeros(0), np.zeros(0), np.zeros((0, N_VALUES), dtype=np.float32)
)


def print_features(colour: ColourPicture, mask: NDArray[np.bool_], share: float = 1.0) -> PrintFeatures:
    """Find SIFT features in a part of a picture.

    Args:
        colour: (height, width, 3) red, green, blue, 0 to 255.
        mask: (height, width) where they may be.
        share: Of the pixels along a row, to which the picture is reduced before.

    Returns:
        The features, in OpenCV's order; a place with several directions has one for each.
    """
    grey = cv2.cvtColor(np.ascontiguousarray(colour), cv2.COLOR_RGB2GRAY)
    allowed = 255 * mask.astype(np.uint8)
    height, width = grey.shape
    if share < 1.0:
        size = max(1, round(share * width)), max(1, round(share * height))
        grey = cv2.resize(grey, size, interpolation=cv2.INTER_AREA)
        allowed = cv2.resize(allowed, size, interpolation=cv2.INTER_NEAREST)
    found, descriptors = _sift().detectAndCompute(grey, allowed)
    if descriptors is None:
        return NO_FEATURES
    roots = np.sqrt(descriptors / np.maximum(descriptors.sum(axis=1, keepdims=True), 1.0))
    figures = np.array([(*each.pt, each.size, each.angle) for each in found])
    larger = np.array([width, height]) / grey.shape[::-1]
    pixels = (figures[:, :2] + 0.5) * larger - 0.5
    return PrintFeatures(
        pixels, figures[:, 2] * larger.mean(), np.radians(figures[:, 3]), roots.astype(np.float32)
    )


def products(one: FloatPicture, other: FloatPicture) -> FloatPicture:
    """Multiply all of some vectors with all of others.

    By OpenCV, which takes one thread for it; BLAS would take several.

    Args:
        one: (N, D).
        other: (K, D).

    Returns:
        (N, K).
    """
    return np.asarray(cv2.gemm(one, other, 1.0, None, 0.0, flags=cv2.GEMM_2_T))


@cache
def _sift() -> Any:
    create: Any = cv2.SIFT_create  # type: ignore[attr-defined,unused-ignore]
    return create(contrastThreshold=_CONTRAST)
