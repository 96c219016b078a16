"""The forks of a truck, which go into the pockets of a pallet."""

from __future__ import annotations

from dataclasses import dataclass

from pickcli.cell.shapes import Body, box


@dataclass(frozen=True)
class Forks:
    """Two forks, lowered. Half their distance is that of APPLE's truck, the other figures are ours.

    Attributes:
        length: m from their heels, where the body of the truck begins, to their tips.
        aside: m from the middle of the truck to the middle of each.
        width: m of each.
        height: m of their upper sides above the floor.
    """

    length: float = 1.15
    aside: float = 0.205
    width: float = 0.1
    height: float = 0.085

    def bodies(self, back: float) -> tuple[Body, ...]:
        """Return the forks as boxes.

        Args:
            back: m from the axle to their tips.

        Returns:
            The right and the left one, in the frame of the truck.
        """
        half = self.width / 2
        return tuple(
            box(name, (-back, y - half, self.height / 2), (self.length - back, y + half, self.height))
            for name, y in (("right fork", -self.aside), ("left fork", self.aside))
        )
