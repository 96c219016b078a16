"""What a cup keeps and bears where its lip stands over the edges of a narrow face."""

from __future__ import annotations

import numpy as np

from pickcli.cell.item import Item
from pickcli.cell.tools.suction_cup import SuctionCup
from pickcli.geometry import Array
from pickcli.scene.scene import PoseNoise

EXACT = PoseNoise()
ON_EDGE = 1e-6  # m, rounding of a cup that is as near to an edge as it may be


def kept_vacuum(item: Item, face: str, tip: Array, cup: SuctionCup, noise: PoseNoise = EXACT) -> float:
    """Return the share of full vacuum that the pump keeps under a cup on a face.

    Args:
        item: The item.
        face: Name of the face.
        tip: (3,) m, the middle of the lip in the item frame.
        cup: The cup.
        noise: Bounds of the item's pose error, by which the cup may be off its place.

    Returns:
        The share: the face's seal if the whole lip is on it, else the least that remains beside open edges.
    """
    if is_covered(item, face, tip, cup):
        return item.seals[face]
    return cup.kept_vacuum(item.seals[face], item.rooms(face, tip), _off(tip, noise))


def bearing_share(item: Item, face: str, tip: Array, cup: SuctionCup, noise: PoseNoise = EXACT) -> float:
    """Return the share of its limits that a cup bears on a face.

    The limits are in proportion to the vacuum. The lever of the lip is no longer than the face is wide, which
    is taken for all of them.

    Args:
        item: The item.
        face: Name of the face.
        tip: (3,) m, the middle of the lip in the item frame.
        cup: The cup.
        noise: Bounds of the item's pose error, by which the cup may be off its place.

    Returns:
        The share.
    """
    kept = kept_vacuum(item, face, tip, cup, noise)
    if is_covered(item, face, tip, cup):
        return kept
    return kept * cup.covered(item.rooms(face, tip), _off(tip, noise))


def is_covered(item: Item, face: str, tip: Array, cup: SuctionCup) -> bool:
    """Tell whether the whole lip, and the inset around it, is on a face.

    Args:
        item: The item.
        face: Name of the face.
        tip: (3,) m, the middle of the lip in the item frame.
        cup: The cup.

    Returns:
        True if it is, and on curved faces, where the sampled places take care of it.
    """
    return float(item.rooms(face, tip).min()) >= cup.radius + item.seal_inset - ON_EDGE


def _off(tip: Array, noise: PoseNoise) -> float:
    """Return how far (m) the cup may be off its place (3,) on the item."""
    return float(noise.at(np.asarray(np.linalg.norm(tip))))
