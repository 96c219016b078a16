"""A strategy as a drawing: its tree from top to bottom, leaves evenly spaced."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from html import escape

from pickcli.strategy.node_types import NodeKind
from pickcli.strategy.strategy_tree import Strategy, StrategyNode

BOX, ROW, GAP = 26, 64, 14  # height of a box, distance of rows, gap between boxes, px
CHARACTER, PADDING = 6.7, 18  # width of a character, and of both margins of a box, px
MAX_CHARACTERS = 46  # of a node's text; the rest is in its tooltip
FILL = {
    NodeKind.CONTROL: "#dfe7f2", NodeKind.DECORATOR: "#eee6f4", NodeKind.CONDITION: "#fdf3d0",
    NodeKind.ACTION: "#dcf0de",
}  # fmt: skip
SYMBOL = {"sequence": "→ ", "fallback": "? "}  # as in Colledanchise and Ögren, 2018


@dataclass(frozen=True)
class _Drawn:
    """A node with its place: the middle of its box, px."""

    node: StrategyNode
    x: float
    y: float
    children: tuple[_Drawn, ...]

    @property
    def text(self) -> str:
        whole = SYMBOL.get(self.node.name, "") + str(self.node)
        return whole if len(whole) <= MAX_CHARACTERS else whole[: MAX_CHARACTERS - 1] + "…"

    @property
    def width(self) -> float:
        return _width(self.text)


def strategy_svg(strategy: Strategy) -> str:
    """Draw a strategy.

    Args:
        strategy: The strategy.

    Returns:
        The text of an SVG file.
    """
    root, width = _placed(strategy.root, float(GAP), 2 * BOX)
    height = max(drawn.y for drawn in _all(root)) + BOX
    shapes = [shape for drawn in _all(root) for shape in _shapes(drawn)]
    width = max(width, _width(strategy.name) + 2 * GAP)
    title = f'<text x="{GAP}" y="{BOX - 6}" font-weight="bold">{escape(strategy.name)}</text>'
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0f}" height="{height:.0f}" '
        f'viewBox="0 0 {width:.0f} {height:.0f}" font-family="sans-serif" font-size="12">'
    )
    return "\n".join([head, '<rect width="100%" height="100%" fill="white"/>', title, *shapes, "</svg>", ""])


def _placed(node: StrategyNode, left: float, y: float) -> tuple[_Drawn, float]:
    """Place a node with everything below it; return it and where it ends on the right, px."""
    own = _width(_Drawn(node, 0.0, 0.0, ()).text)
    if not node.children:
        return _Drawn(node, left + own / 2, y, ()), left + own + GAP
    children, x = [], left
    for child in node.children:
        drawn, x = _placed(child, x, y + ROW)
        children.append(drawn)
    missing = own + GAP - (x - left)
    if missing > 0:  # the box is wider than all below it: these are moved to its middle
        children = [_moved(child, missing / 2) for child in children]
        x += missing
    middle = (children[0].x + children[-1].x) / 2
    middle = min(max(middle, left + own / 2), x - GAP - own / 2)
    return _Drawn(node, middle, y, tuple(children)), x


def _moved(drawn: _Drawn, by: float) -> _Drawn:
    return _Drawn(drawn.node, drawn.x + by, drawn.y, tuple(_moved(child, by) for child in drawn.children))


def _all(drawn: _Drawn) -> Iterator[_Drawn]:
    yield drawn
    for child in drawn.children:
        yield from _all(child)


def _shapes(drawn: _Drawn) -> Iterator[str]:
    for child in drawn.children:
        top, bottom = drawn.y + BOX / 2, child.y - BOX / 2
        yield f'<path d="M{drawn.x:.1f} {top:.1f}L{child.x:.1f} {bottom:.1f}" stroke="#888" fill="none"/>'
    radius = BOX / 2 if drawn.node.type.kind is NodeKind.CONDITION else 3
    yield (
        f"<g><title>{escape(f'{drawn.node}: {drawn.node.type.summary}')}</title>"
        f'<rect x="{drawn.x - drawn.width / 2:.1f}" y="{drawn.y - BOX / 2:.1f}" width="{drawn.width:.1f}" '
        f'height="{BOX}" rx="{radius:g}" fill="{FILL[drawn.node.type.kind]}" stroke="#555"/>'
        f'<text x="{drawn.x:.1f}" y="{drawn.y + 4:.1f}" text-anchor="middle">{escape(drawn.text)}</text></g>'
    )


def _width(text: str) -> float:
    return CHARACTER * len(text) + PADDING
