"""Warning of items in a scene file that cannot be at rest: plans would be certified for a pile that moves."""

from __future__ import annotations

from pickcli.files.file_warnings import FileWarnings
from pickcli.files.source import Key
from pickcli.scene.scene import Scene
from pickcli.scene.scene_warnings import NOT_AT_REST
from pickcli.statics.supports import supports_of


def warn_of_motion(warnings: FileWarnings, scene: Scene) -> None:
    """Warn of items that cannot be at rest at their poses.

    A scene with a point cloud is not judged: its points may carry items.

    Args:
        warnings: Collects them.
        scene: The scene.
    """
    if scene.cloud is not None or NOT_AT_REST in warnings.accepted:
        return
    balance = supports_of(scene).balance
    text = "cannot be at rest at this pose: nothing that it touches keeps it from falling or rolling"
    moving: dict[str, tuple[Key, str]] = {
        placed.id: (("items", k), f"{placed.id} {text}")
        for k, placed in enumerate(scene.items)
        if placed.location in scene.cell.places and not balance.is_at_rest(placed.id)
    }
    warnings.add_alike(NOT_AT_REST, moving, ("items",), "are the poses in the right frame, and settled?")
