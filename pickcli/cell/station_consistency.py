"""What a cell file says of its pod and its tote: figures that must fit together."""

from __future__ import annotations

from itertools import pairwise

from pickcli.cell.cell_schema import PodModel, ToteModel
from pickcli.cell.pod import flat_from
from pickcli.cell.references import unique
from pickcli.files.yaml_reader import Key, Source


def check_pod(source: Source, pod: PodModel) -> None:
    """Check that a pod's walls, boards and lips lie in their order, and that no two bins share a name.

    Args:
        source: Collects the mistakes with their places in the file.
        pod: The pod as it stands in the file.
    """
    _ascending(
        source,
        ("divider", pod.divider + pod.divider_thickness),
        ("post", pod.post),
        ("side_wall", pod.side_wall),
        ("width", pod.width / 2),
    )
    _ascending(
        source,
        ("lip_depth", pod.lip_depth),
        ("hanging_lip_depth", pod.hanging_lip_depth),
        ("floor_slope", flat_from(pod)),  # where the slope ends
        ("back_wall", pod.back_wall),
        ("depth", pod.depth),
    )
    for i, (upper, lower) in enumerate(pairwise(pod.rows)):
        gap = upper.floor_front - pod.board_thickness - lower.ceiling_front
        if abs(gap) > 5e-4:
            source.add(
                ("pod", "rows", i + 1, "ceiling_front"),
                f"expected the underside of the board above, {lower.ceiling_front + gap:.4f} m, "
                f"got {lower.ceiling_front:g}; correct it, floor_front above or board_thickness",
            )
    keys: list[Key] = [("pod", "rows", i, "bins", j) for i in range(len(pod.rows)) for j in range(3)]
    unique(source, keys, [name for row in pod.rows for name in row.bins])


def _ascending(source: Source, *places: tuple[str, float]) -> None:
    """Note every place, on the way outwards or inwards, that does not lie beyond the one before."""
    for (before, low), (name, high) in pairwise(places):
        if not low < high:
            text = f"puts it at {high:.4g} m, expected beyond {low:.4g} m ({before}); correct one of the two"
            source.add(("pod", name), text)


def check_tote(source: Source, tote: ToteModel) -> None:
    """Check that the tote's flange runs around its rim, outside of the walls.

    Args:
        source: Collects the mistakes with their places in the file.
        tote: The tote as it stands in the file.
    """
    for axis, name in enumerate("xy"):
        low = tote.inner.lower[axis] - tote.wall_thickness
        high = tote.inner.upper[axis] + tote.wall_thickness
        if not tote.flange.lower[axis] <= low < high <= tote.flange.upper[axis]:
            source.add(
                ("tote", "inner"),
                f"puts the walls at {name} from {low:g} to {high:g}, expected inside the flange's "
                f"{tote.flange.lower[axis]:g} to {tote.flange.upper[axis]:g}; correct one of the two",
            )
