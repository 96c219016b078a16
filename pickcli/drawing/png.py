"""Renders pictures as PNG. The only module that uses matplotlib."""

from __future__ import annotations

import io
from typing import Any

import numpy as np

from pickcli.drawing.picture import Colour, Coverage, DrawnNode, Picture
from pickcli.errors import not_installed
from pickcli.geometry import Array

try:
    import matplotlib
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D
    from matplotlib.patheffects import withStroke
    from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection
except ImportError:
    raise not_installed("matplotlib", "view", "a picture in .png") from None

_SIZE, _DPI = (18.0, 10.0), 110  # inches
_SEEN = {
    Colour.POD: 0.05,
    Colour.TOTE: 0.16,
    Colour.PLACE: 0.14,
    Colour.OBSTACLE: 0.07,
    Colour.ARM: 0.1,
}  # opacity
_FROM = (16.0, -138.0)  # degrees: elevation and azimuth of the eye, over the robot's right shoulder


def png_bytes(picture: Picture) -> bytes:
    """Render a picture as PNG, without a window or global state; equal pictures give equal bytes.

    Args:
        picture: The picture.

    Returns:
        Bytes of the file.
    """
    with matplotlib.rc_context({"font.size": 9}):
        figure = Figure(_SIZE, _DPI, layout="constrained")
        widths = (1.0,) if picture.coverage is None else (2.6, 1.0)
        parts: Any = figure.subfigures(1, len(widths), width_ratios=widths, squeeze=False)[0]
        scene = parts[0].add_subplot(projection="3d", computed_zorder=False)
        _draw_cell(scene, picture)
        _draw_legend(scene, picture)
        if picture.coverage is not None:
            _draw_coverage(parts[1].add_subplot(), picture.coverage)
        figure.suptitle(picture.title, fontsize=15)
        file = io.BytesIO()
        figure.savefig(file, format="png", metadata={"Software": None})
    return file.getvalue()


def _draw_cell(axes: Any, picture: Picture) -> None:
    low, high = picture.bounds
    for ink, opacity in _SEEN.items():
        solids = (s for s in picture.solids if s.ink is ink and _is_seen(s.corners, low, high))
        # matplotlib does not clip at the edge of the axes.
        faces = [np.clip(solid.corners, low, high)[face] for solid in solids for face in solid.faces]
        edge = "none" if ink is Colour.ARM else ink  # the arm's many triangles have no meaning
        style = {"facecolor": ink, "edgecolor": edge, "linewidth": 0.4, "alpha": opacity, "zorder": 1}
        _add(axes, Poly3DCollection, faces, style)
    arm, *paths = picture.lines
    for _, ink in picture.lines_by_ink:
        points = [line.points for line in paths if line.ink is ink]
        _add(axes, Line3DCollection, points, {"colors": ink, "linewidths": 0.9, "alpha": 0.6, "zorder": 2})
    seen = arm.points[((arm.points >= low) & (arm.points <= high)).all(axis=1)]
    axes.plot(*seen.T, color=arm.ink, linewidth=4.0, alpha=0.7, marker="o", markersize=5, zorder=3)
    for node in picture.nodes:
        _draw_node(axes, node)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    has_shelf = any(solid.ink is Colour.POD for solid in picture.solids)
    axes.set(xlabel="x, m (into the shelf)" if has_shelf else "x, m", ylabel="y, m", zlabel="z, m")
    axes.set_box_aspect(high - low, zoom=1.22)  # equal scale on all axes
    axes.view_init(*_FROM)


def _add(axes: Any, kind: Any, parts: list[Array], style: dict[str, Any]) -> None:
    if parts:  # empty collections are errors
        axes.add_collection3d(kind(parts, **style))


def _draw_node(axes: Any, node: DrawnNode) -> None:
    size = 6.5 if node.is_main else 4.5
    axes.plot(*node.place[:, None], "o", color=node.ink, markersize=size, zorder=4)
    if not node.name:
        return
    halo = [withStroke(linewidth=1.8, foreground="white", alpha=0.8)]
    axes.text(
        *node.place,
        f"  {node.name}",
        color=node.ink,
        fontsize=1.3 * size,
        zorder=5,
        va="center",
        path_effects=halo,
    )


def _is_seen(corners: Array, low: Array, high: Array) -> bool:
    return bool((corners.max(axis=0) > low).all() and (corners.min(axis=0) < high).all())


def _draw_coverage(axes: Any, coverage: Coverage) -> None:
    names = [bar.name for bar in coverage.bars]
    left = np.zeros(len(names))
    for i, (kind, ink) in enumerate(coverage.kinds):
        widths = np.array([bar.counts[i] for bar in coverage.bars])
        drawn = axes.barh(names, widths, left=left, color=ink, label=kind)
        axes.bar_label(drawn, [str(n) if n else "" for n in widths], label_type="center", color="white")
        left += widths
    axes.invert_yaxis()
    axes.set_title(coverage.title, fontsize=10)
    axes.legend(loc="upper left", bbox_to_anchor=(0.0, -0.04), frameon=False)
    axes.spines[["top", "right"]].set_visible(False)


def _draw_legend(axes: Any, picture: Picture) -> None:
    axes.text2D(0.02, 0.98, "\n".join(picture.words), va="top", transform=axes.transAxes, linespacing=1.6)
    if not picture.lines_by_ink:
        return
    handles = [Line2D([], [], color=ink, label=name, linewidth=2.0) for name, ink in picture.lines_by_ink]
    axes.legend(
        handles=handles, title="path of the tip of the cup", alignment="left", frameon=False,
        loc="upper left", bbox_to_anchor=(0.01, 0.9),
    )  # fmt: skip
