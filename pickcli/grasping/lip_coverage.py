"""What a cup keeps and bears on a face, where its lip may stand over the edges of a box."""

from __future__ import annotations

import numpy as np

from pickcli.cell.item import Item
from pickcli.cell.tools.suction_cup import SuctionCup
from pickcli.geometry import Array
from pickcli.scene.scene import PoseNoise

EXACT = PoseNoise()


def kept_vacuum(item: Item, face: str, tip: Array, cup: SuctionCup, noise: PoseNoise = EXACT) -> float:
    """Return the share of full vacuum that the pump keeps under a cup on a face.

    Args:
        item: The item.
        face: Name of the face.
        tip: (3,) m, the middle of the lip in the item frame.
        cup: The cup.
        noise: Bounds of the item's pose error, by which the cup may be off its place.

    Returns:
        The share: the face's seal if the whole lip is surely on it, else the least beside open edges.
    """
    return cup.kept_vacuum(item.seals[face], item.rooms(face, tip), _off(item, face, tip, noise))


def bearing_share(item: Item, face: str, tip: Array, cup: SuctionCup, noise: PoseNoise = EXACT) -> float:
    """Return the share of its limits that a cup bears on a face.

    The limits are in proportion to the vacuum. The lever of the lip is no longer than the face reaches under
    it, which is taken for all of them.

    Args:
        item: The item.
        face: Name of the face.
        tip: (3,) m, the middle of the lip in the item frame.
        cup: The cup.
        noise: Bounds of the item's pose error, by which the cup may be off its place.

    Returns:
        The share.
    """
    lever = cup.covered(item.rooms(face, tip), _off(item, face, tip, noise))
    return kept_vacuum(item, face, tip, cup, noise) * lever


def lip_on(item: Item, face: str, T_item_tip: Array) -> Array:
    """Return where the middle of the lip met a face, before the cup was pressed on along its axis.

    Args:
        item: The item.
        face: Name of the face.
        T_item_tip: (4, 4) pose of the tool, pressed on.

    Returns:
        (3,) m in the item frame; the tip itself on round faces.
    """
    tip, axis = T_item_tip[:3, 3], T_item_tip[:3, 2]
    if face[0] not in "+-":
        return np.asarray(tip)
    k = "xyz".index(face[1])
    return np.asarray(tip - axis * (tip[k] - item.height(face)) / axis[k])


def _off(item: Item, face: str, tip: Array, noise: PoseNoise) -> float:
    """Return how far (m) the cup may be off its place (3,), which the press may have moved off the face."""
    at = tip.copy()
    if face[0] in "+-":
        k = "xyz".index(face[1])
        at[k] = item.height(face)
    return float(noise.at(np.asarray(np.linalg.norm(at))))
