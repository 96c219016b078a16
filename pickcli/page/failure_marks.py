"""Converts reasons of failures to marks: the bodies involved, depth, time, and rejected grasp."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable

from pickcli.errors import Reason
from pickcli.motion.plan import GraspKind
from pickcli.page.page_motion import Approach, Mark
from pickcli.page.page_scene import Tone
from pickcli.scene.scene import Scene

MAX_MARKS = 24  # largest number of marks per failure

_WHEN = re.compile(r"\bat (\d+\.\d+) s\b")
_DEEP = re.compile(r"(\d+(?:\.\d+)?) mm deep")
_WORD = re.compile(r"[\w#.-]+")


def failure_marks(
    reasons: Iterable[Reason], known: Collection[str], item: str = "", t: float | None = None
) -> tuple[Mark, ...]:
    """Convert the reasons of one failure to marks; reasons that differ only in figures share one.

    Args:
        reasons: The reasons, in their order.
        known: Names of known links, bodies and items.
        item: Id of the item to be grasped, "" without one.
        t: Time of the failure, s; None to search it in the reasons.

    Returns:
        The marks, those with a rejected grasp or a named body first.
    """
    found: dict[tuple[object, ...], Mark] = {}
    for reason in reasons:
        mark = _mark(reason, known, item, t)
        key = (mark.title, mark.names, mark.grasp)
        before = found.get(key)
        if before is None:
            found[key] = mark
        else:
            deepest = max((m for m in (before, mark)), key=lambda m: m.depth or 0.0)
            found[key] = Mark(**{**vars(deepest), "count": before.count + 1})
    ranked = sorted(found.values(), key=lambda mark: mark.grasp is None and not mark.names)
    return tuple(ranked[:MAX_MARKS])


def named_parts(scene: Scene) -> frozenset[str]:
    """Return all names in a scene that reasons may contain.

    Args:
        scene: The scene.

    Returns:
        Names of links, bodies and items.
    """
    links = {link.name for link in scene.cell.robot.links}
    bodies = {body.name for body, _ in scene.standing}
    items = {placed.id for placed in scene.items}
    return frozenset(links | bodies | items)


def _mark(reason: Reason, known: Collection[str], item: str, t: float | None) -> Mark:
    text = str(reason)
    grasp = GraspKind.named_in(reason.where)
    deep, when = (pattern.search(text) for pattern in (_DEEP, _WHEN))
    words = [word.strip(".-") for word in _WORD.findall(reason.detail)]
    names = [word for word in (*words, reason.in_the_way) if word in known]
    depth = None if deep is None else round(float(deep[1]) / 1e3, 6)
    return Mark(
        title=reason.what,
        detail=text,
        t=float(when[1]) if when is not None else t,
        tone=Tone.BAD,
        names=tuple(dict.fromkeys(names)),
        grasp=None if grasp is None or not item else Approach(item, grasp.face, grasp.kind),
        depth=depth,
    )
