"""What was perceived in a place, and of the pod, as lines of text."""

from __future__ import annotations

from collections.abc import Iterable
from math import degrees
from typing import TYPE_CHECKING

from pickcli.commands.output.table import table_lines

if TYPE_CHECKING:
    from pickcli.cell.cell import Cell
    from pickcli.geometry import Array
    from pickcli.perception.items.item_observation import ItemObservation, PlaceObservation
    from pickcli.perception.items.routing import ItemRoute
    from pickcli.perception.pod_pose import PodEstimate

_HEAD = ("item", "by", "confidence", "within", "and", "surface", "position in m, or why not")


def perceived_lines(observed: PlaceObservation) -> list[str]:
    """Tell what was perceived in a place.

    Args:
        observed: The answers for its items.

    Returns:
        A line for the place, a table of its items, and what else is there.
    """
    from pickcli.perception.items.confidence import truncated

    n = len(observed.items)
    answered = sum(item.is_answer for item in observed.items)
    found = f"{answered} of {n} listed items found" if n else "no items are listed to be there"
    lines = [f"{observed.place}: {found}, {observed.seen:.0%} of its room is seen"]
    rows = [
        [
            item.id,
            "" if item.T_world_item is None else item.found_by.value,
            truncated(item.confidence),
            *_bound(item),
            item.refusal or _position(item.T_world_item),
        ]
        for item in observed.items
    ]
    lines += [f"  {line}" for line in (table_lines(_HEAD, rows) if rows else ())]
    lines += [f"  {line}" for line in route_lines((item.id, item.route) for item in observed.items)]
    if observed.unexplained:
        part = observed.unexplained[0]
        size = " x ".join(f"{1e3 * v:.0f}" for v in part.high - part.low)
        whose = "not listed" if observed.has_unlisted else "refused above or not listed"
        lines.append(f"  something of {size} mm is there that is {whose}")
    return lines


def route_lines(routes: Iterable[tuple[str, ItemRoute | None]]) -> list[str]:
    """Tell by what items are looked for.

    Args:
        routes: By id of the item; those that are not known any more are left out.

    Returns:
        A line for each different route, with its items.
    """
    items: dict[str, list[str]] = {}
    for item_id, route in routes:
        if route is not None:
            items.setdefault(route.text, []).append(item_id)
    return [f"{text}: {', '.join(ids)}" for text, ids in items.items()]


def pod_lines(pod: PodEstimate, cell: Cell) -> list[str]:
    """Tell where the pod stands.

    Args:
        pod: The estimate.
        cell: The cell.

    Returns:
        A line for its pose, one for the bounds of the error, one for how much of the picture says so, and,
        where that is known, one for by what it was found.
    """
    from pickcli.cell.pod_tolerance import pod_stand
    from pickcli.geometry import inverse
    from pickcli.perception.pod_pose import PodStart

    error = pod.error
    begun = {PodStart.LEGS: "its two front legs", PodStart.BOXES: "all of its boxes"}
    within = f"{1e3 * error.x:.1f} mm in x, {1e3 * error.y:.1f} mm in y, {degrees(error.yaw):.2f} degrees"
    lines = [
        f"the pod stands {pod_stand(inverse(cell.T_world_pod) @ pod.T_world_pod)}",
        f"  within {within}; no point of its front is off by more than {1e3 * pod.front_error:.1f} mm",
        f"  {pod.explained:.0%} of {pod.n_pixels} pixels show it, the others items or what is before it",
    ]
    return (
        lines if pod.start is None else [*lines, f"  found from {begun[pod.start]}, then fitted as a whole"]
    )


def _bound(item: ItemObservation) -> tuple[str, str, str]:
    """By how much its middle, its orientation and any point of its surface may be off."""
    if item.bound is None or not item.is_answer:
        return "", "", ""
    surface = 1e3 * item.bound.bound(item.item)
    return f"{1e3 * item.bound.position:.1f} mm", f"{degrees(item.bound.angle):.1f} deg", f"{surface:.1f} mm"


def _position(T: Array | None) -> str:
    return "" if T is None else " ".join(f"{v:.3f}" for v in T[:3, 3])
