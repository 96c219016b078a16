"""Pictures of a place in the kernel, in which hypotheses of items are rendered and compared."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from pickcli.cell.place import Place
from pickcli.cell.sensors.sensor_model import DepthModel
from pickcli.geometry import Array, inverse
from pickcli.kernel import PlacePicture
from pickcli.perception.depth_picture import kernel_noise
from pickcli.perception.items.colour_model import colour_costs, colour_labels, label_shares
from pickcli.perception.items.place_view import PlaceView
from pickcli.perception.items.product_model import SOLID_KINDS, ProductModel
from pickcli.perception.rendered_scene import OwnerKind, RenderedScene
from pickcli.scene.colours import static_colour

KnownSolids: TypeAlias = tuple[Array, Array, "np.ndarray[tuple[int], np.dtype[np.int32]]"]

_FRONT, _BEHIND = 4.0, 8.0  # nats, most that a depth before and behind what is expected costs
_LOST = 0.1  # share of pixels without a depth for other reasons than the surface
_AROUND = 0.02  # m around a place in which items are kept out of known solids


@dataclass(frozen=True)
class PictureCosts:
    """What pixels of a picture cost.

    Attributes:
        slack: m that surfaces may be off besides noise.
        unseen: nats, most that no depth costs where the second eye should see something else, or the surface
            would be out of the sensor's range.
        weight: Of each pixel.
    """

    slack: float
    unseen: float
    weight: float = 1.0


def place_picture(
    view: PlaceView, models: Sequence[ProductModel], costs: Sequence[Array], solids: KnownSolids,
    depth_model: DepthModel, pixels: PictureCosts,
) -> PlacePicture:  # fmt: skip
    """Put a view of a place into the kernel.

    Args:
        view: The view.
        models: Models of all items, whose indices are those of the kernel's products.
        costs: Costs of labels of colour on what is known, then on each item.
        solids: Known solids around, by ``solids_around``.
        depth_model: How depth was measured.
        pixels: What pixels cost.

    Returns:
        The picture.
    """
    picture = PlacePicture(
        view.camera.intrinsics,
        np.ascontiguousarray(view.depth),
        np.ascontiguousarray(view.share),
        np.ascontiguousarray(colour_labels(view.colour)),
        [np.ascontiguousarray(view.known.depth), np.ascontiguousarray(np.nan_to_num(view.facing))],
        solids,
        costs[0],
        kernel_noise(depth_model),
        np.array([pixels.slack, _FRONT, _BEHIND, _LOST, pixels.unseen, pixels.weight]),
    )
    for model, own in zip(models, costs[1:], strict=True):
        picture.add(
            model.kind.value, model.half_extents, depth_model.no_return.get(model.item.material, 0.0), own
        )
    return picture


def known_and_item_costs(carrier: str, models: Sequence[ProductModel]) -> list[Array]:
    """Compute what labels of colour cost on what is known, and on each item.

    Args:
        carrier: Name of the carrier of the place.
        models: Models of the items.

    Returns:
        (n_labels,) nats each; those of the carrier first.
    """
    own = label_shares(255.0 * np.array([static_colour(carrier)[:3]]))
    return colour_costs([own, *(model.label_shares for model in models)])


def solids_around(
    known: RenderedScene, place: Place, T_world_place: Array, T_world_camera: Array
) -> KnownSolids:
    """Collect known solids near a place that items do not reach into.

    Args:
        known: All that is known; links are left out, as they are not there to stay.
        place: The place.
        T_world_place: (4, 4) its pose.
        T_world_camera: (4, 4) pose of the camera.

    Returns:
        Poses (N, 4, 4) in the camera's frame, half extents (N, 3) in m, and kinds (N,).
    """
    low, high = place.room.low - _AROUND, place.room.high + _AROUND
    kept = []
    for solid in known.solids:
        if solid.kind is OwnerKind.LINK or solid.shape.kind not in SOLID_KINDS:
            continue
        T = inverse(T_world_place) @ solid.T_world_shape
        reach = solid.shape.reach(T[:3, :3])
        if (T[:3, 3] - reach < high).all() and (T[:3, 3] + reach > low).all():
            kept.append(solid)
    return (
        np.array([inverse(T_world_camera) @ solid.T_world_shape for solid in kept]).reshape(-1, 4, 4),
        np.array([solid.shape.extents / 2 for solid in kept]).reshape(-1, 3),
        np.array([SOLID_KINDS[solid.shape.kind].value for solid in kept], dtype=np.int32),
    )
