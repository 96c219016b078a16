"""Pages of a cell and of a scene."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import replace

from pickcli.cell.cell import Cell
from pickcli.cell.pod_tolerance import pod_stand
from pickcli.page.cell_parts import (
    item_parts,
    node_parts,
    place_parts,
    robot_part,
    standing_parts,
)
from pickcli.page.page_document import PageDocument, PageTable
from pickcli.page.page_scene import Fact, Tone
from pickcli.scene.scene import PoseNoise, Scene, empty_scene


def cell_page(cell: Cell) -> PageDocument:
    """Create the page of a cell: robot, places, obstacles and named configurations.

    Args:
        cell: The cell.

    Returns:
        The page.
    """
    limits, scale = cell.robot.limits, cell.speed_scale
    rows = tuple(
        (name, _range(low, high, unit), f"{v * scale:.2f}", f"{a * scale:.1f}", f"{j:.0f}")
        for name, unit, low, high, v, a, j in zip(
            cell.robot.joint_names, cell.robot.units, limits.lower.tolist(), limits.upper.tolist(),
            limits.velocity.tolist(), limits.acceleration.tolist(), limits.jerk.tolist(), strict=True,
        )
    )  # fmt: skip
    subtitle = f"{cell.robot.name}, {len(rows)} joints"
    return replace(
        standing_page(empty_scene(cell), "cell", f"Cell {cell.name}", subtitle),
        facts=tuple(_cell_facts(cell)),
        nodes=node_parts(cell),
        tables=(PageTable("Joints", ("joint", "range", "velocity", "accel.", "jerk"), rows),),
    )


def scene_page(scene: Scene) -> PageDocument:
    """Create the page of a scene: a cell with its items.

    Args:
        scene: The scene.

    Returns:
        The page.
    """
    counts = Counter(placed.location for placed in scene.items)
    rows = tuple((place, str(counts[place])) for place in scene.cell.places if counts[place])
    held = () if scene.held is None else (Fact("held", scene.held.id),)
    subtitle = f"{len(scene.items)} items, seed {scene.seed}"
    return replace(
        standing_page(scene, "scene", f"Scene of {scene.cell.name}", subtitle),
        facts=(
            Fact("pod", pod_stand(scene.T_nominal_pod)),
            Fact("poses off by", _off_by(scene.noise)),
            *(Fact(f"{i.id} off by", _off_by(i.noise)) for i in scene.items if i.noise is not None),
            *held,
        ),
        tables=(PageTable("Items by place", ("place", "items"), rows),) if rows else (),
    )


def _off_by(noise: PoseNoise) -> str:
    surface = "" if noise.displacement is None else f", its surface by {1e3 * noise.displacement:.1f} mm"
    return f"up to {1e3 * noise.position:.1f} mm and {noise.angle:.3f} rad{surface}"


def standing_page(scene: Scene, kind: str, title: str, subtitle: str) -> PageDocument:
    """Create a page of the static content of a scene, with the arm at rest.

    Args:
        scene: The scene.
        kind: Kind of the page.
        title: Its heading.
        subtitle: Text below the heading.

    Returns:
        The page, without facts.
    """
    return PageDocument(
        kind=kind,
        title=title,
        subtitle=subtitle,
        robot=robot_part(scene.cell),
        groups=standing_parts(scene),
        items=item_parts(scene),
        places=place_parts(scene),
    )


def _cell_facts(cell: Cell) -> Iterator[Fact]:
    tool = cell.robot.tool
    yield Fact("tool", "none" if tool.is_bare else f"{tool.lance_link}: {', '.join(map(str, tool.states))}")
    yield Fact("places", ", ".join(cell.places) or "none")
    yield Fact("devices", ", ".join(cell.devices) or "none")
    yield Fact("configurations", str(len(cell.configurations)))
    yield Fact("clearance", f"{1e3 * cell.clearance:.1f} mm is kept")
    for warning in cell.warnings:
        yield Fact("warning", warning, Tone.FAIR)


def _range(low: float, high: float, unit: str) -> str:
    return "turns on" if low == -float("inf") else f"{low:.2f} to {high:.2f} {unit}"
