"""A picture as a page to turn about, that needs nothing else: the only file that imports plotly."""

from __future__ import annotations

import html
from typing import Any

import numpy as np

from pickcli.drawing.picture import Colour, Coverage, Picture
from pickcli.errors import not_installed
from pickcli.geometry import Array

try:
    import plotly.graph_objects as go
    from plotly.subplots import make_subplots
except ImportError:
    raise not_installed("plotly", "view", "a page in .html") from None

_SEEN = {Colour.POD: 0.12, Colour.TOTE: 0.35, Colour.PLACE: 0.3,
         Colour.OBSTACLE: 0.12, Colour.ARM: 0.3}  # opacity  # fmt: skip


def html_bytes(picture: Picture) -> bytes:
    """A picture as one HTML file with everything in it. Same picture, same bytes.

    Args:
        picture: The picture.

    Returns:
        Bytes of the file.
    """
    coverage = picture.coverage
    titles, widths = ("",) if coverage is None else ("", coverage.title), [0.75, 0.25]
    figure = make_subplots(
        1, len(titles), column_widths=widths[: len(titles)], subplot_titles=titles,
        specs=[[{"type": "scene"}, {"type": "bar"}][: len(titles)]],
    )  # fmt: skip
    figure.add_traces([*_solids(picture), *_lines(picture), _nodes(picture)], rows=1, cols=1)
    if coverage is not None:
        figure.add_traces(_bars(coverage), rows=1, cols=2)
    told = "<br>".join(html.escape(line) for line in picture.words)
    figure.update_layout(
        title={"text": f"{html.escape(picture.title)}<br><sub>{told}</sub>"}, barmode="stack",
        scene=_scene(picture), legend={"orientation": "h"}, margin={"t": 130, "l": 0, "r": 10, "b": 10},
    )  # fmt: skip
    figure.update_yaxes(autorange="reversed")
    page = figure.to_html(include_plotlyjs=True, full_html=True, div_id="picture", default_height="95vh")
    return str(page).encode()


def _scene(picture: Picture) -> dict[str, Any]:
    """Equal scale on all axes, seen over the robot's right shoulder."""
    ranges = zip("xyz", *picture.bounds, strict=True)
    axes = {f"{axis}axis": {"range": [low, high], "title": f"{axis}, m"} for axis, low, high in ranges}
    eye = {"x": -1.3, "y": -1.1, "z": 0.5}
    return {**axes, "aspectmode": "data", "camera": {"eye": eye}}


def _solids(picture: Picture) -> list[Any]:
    """One mesh for all solids of a kind: few traces turn smoothly."""
    low, high = picture.bounds
    meshes = []
    for ink, opacity in _SEEN.items():
        chosen = [solid for solid in picture.solids if solid.ink is ink]
        if chosen:
            firsts = np.cumsum([0, *(len(solid.corners) for solid in chosen[:-1])])
            x, y, z = np.clip(np.concatenate([solid.corners for solid in chosen]), low, high).T
            triangles = [solid.triangles + first for solid, first in zip(chosen, firsts, strict=True)]
            i, j, k = np.concatenate(triangles).T
            mesh = {"x": x, "y": y, "z": z, "i": i, "j": j, "k": k, "hoverinfo": "skip"}
            meshes.append(go.Mesh3d(**mesh, color=str(ink), opacity=opacity, flatshading=True))
    return meshes


def _lines(picture: Picture) -> list[Any]:
    arm, *paths = picture.lines
    low, high = picture.bounds
    seen = arm.points[((arm.points >= low) & (arm.points <= high)).all(axis=1)]
    traces = [_trace(seen, [arm.name] * len(seen), arm.ink, 7.0, arm.name)]
    for name, ink in picture.lines_by_ink:
        chosen = [line for line in paths if line.ink is ink]
        if chosen:
            # A row without numbers lifts the pen.
            gap = np.full((1, 3), np.nan)
            points = np.concatenate([part for line in chosen for part in (line.points, gap)])
            names = [line.name for line in chosen for _ in range(len(line.points) + 1)]
            traces.append(_trace(points, names, ink, 2.0, name))
    return traces


def _trace(points: Array, names: list[str], ink: Colour, width: float, legend: str) -> Any:
    x, y, z = points.T
    return go.Scatter3d(
        x=x, y=y, z=z, mode="lines", line={"color": str(ink), "width": width}, name=legend,
        text=names, hoverinfo="text",
    )  # fmt: skip


def _nodes(picture: Picture) -> Any:
    nodes = picture.nodes
    sizes = [5 if node.is_main else 3 for node in nodes]
    x, y, z = np.array([node.place for node in nodes]).reshape(-1, 3).T
    return go.Scatter3d(
        x=x, y=y, z=z, mode="markers+text", text=[node.name for node in nodes], hoverinfo="text",
        marker={"color": [str(node.ink) for node in nodes], "size": sizes},
        textfont={"color": [str(node.ink) for node in nodes], "size": 10}, name="configurations",
    )  # fmt: skip


def _bars(coverage: Coverage) -> list[Any]:
    names = [bar.name for bar in coverage.bars]
    return [
        go.Bar(x=[bar.counts[i] for bar in coverage.bars], y=names, orientation="h", name=kind,
               marker_color=str(ink), texttemplate="%{x}")
        for i, (kind, ink) in enumerate(coverage.kinds)
    ]  # fmt: skip
