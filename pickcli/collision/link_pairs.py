"""Checkers of single pairs of links, for counting over configurations which of them collide."""

from __future__ import annotations

from collections.abc import Container, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.cell.tool import ToolState
from pickcli.collision.collision_world import KERNEL_KINDS
from pickcli.collision.robot_model import CollisionModel
from pickcli.geometry import Array
from pickcli.kernel import Checker


@dataclass(frozen=True, eq=False)
class LinkPair:
    """Two links that move relative to each other.

    Attributes:
        a: Name of one link; a static one if any is.
        b: Name of the other.
        checker: Checker of their spheres against each other, and of nothing else.
    """

    a: str
    b: str
    checker: Checker


def link_pairs(
    model: CollisionModel, tool_state: ToolState, among: Container[frozenset[str]] | None = None
) -> Iterator[LinkPair]:
    """Yield the pairs of links that planning tests against each other.

    Args:
        model: Collision model of a cell's robot.
        tool_state: State of the tool.
        among: Names of pairs; None for all pairs.

    Yields:
        The pairs, those with a static link first.
    """
    robot, names = model.state(tool_state), model.frame_names
    solids = dict[str, list[tuple[Array, Shape]]]()
    for link, T, body in model.static_bodies():
        solids.setdefault(link, []).append((T @ body.T_parent_shape, body.shape))
    for link, T, radius in model.static_spheres():
        solids.setdefault(link, []).append((T, Shape(ShapeKind.SPHERE, (radius,))))
    for frame in np.unique(robot.spheres.frames).tolist():
        moving = names[frame]
        for link, standing in solids.items():
            is_asked = among is None or frozenset((link, moving)) in among
            if is_asked and not model.are_joined(link, moving) and not model.is_allowed(link, moving):
                checker = robot.of_frames([frame])
                _surround(checker, standing)
                yield LinkPair(link, moving, checker)
    for i, j in robot.self_pairs.tolist():
        if among is None or frozenset((names[i], names[j])) in among:
            yield LinkPair(names[i], names[j], robot.of_frames([i, j]))


def _surround(checker: Checker, solids: Sequence[tuple[Array, Shape]]) -> None:
    """Set the world of a checker to solids at poses (4, 4)."""
    checker.set_world(
        np.array([T for T, _ in solids]),
        np.array([shape.extents / 2 for _, shape in solids]),
        np.zeros(len(solids), dtype=np.uint64),
        np.array([KERNEL_KINDS[shape.kind] for _, shape in solids], dtype=np.int32),
    )
