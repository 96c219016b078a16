"""Which pairs the physics lets through each other: those that may overlap, and what holds with its item."""

from __future__ import annotations

from itertools import product

from pickcli.scene.scene import Scene
from pickcli.simulation.engine import Engine
from pickcli.simulation.grip import Grip
from pickcli.simulation.scene_bodies import rigid_pairs, standing_links


class CollisionFilter:
    """The pairs of one robot.

    Attributes:
        exempt: Pairs (link, body or other link) that never count as contacts: those that the cell lists, and
            links that cannot move relative to each other. What stands cannot collide with what else stands:
            such pairs are among them, their physics moves nothing.
        let_go_through: Names of items that the links that hold go through now.

    Args:
        engine: Where the robot and the items are.
        robot: Name of the robot's body.
        scene: With the cell as the arm that moves sees it.
    """

    def __init__(self, engine: Engine, robot: str, scene: Scene) -> None:
        self._engine, self._robot, self._cell = engine, robot, scene.cell
        self.let_go_through: frozenset[str] = frozenset()
        standing = (body.name for body, _ in scene.standing)
        self.exempt = frozenset(product(standing_links(scene.cell.robot), standing)) | self._switched_off()

    def _switched_off(self) -> set[tuple[str, str]]:
        """Switch off the physics of pairs that may overlap; returns them."""
        engine, robot, pairs = self._engine, self._robot, set[tuple[str, str]]()
        for allowed in self._cell.allowed_pairs:
            for link, other in ((allowed.a, allowed.b), (allowed.b, allowed.a)):
                if engine.has_link(robot, link) and engine.has_body(other):
                    engine.set_collision(robot, link, other, "", on=False)
                    pairs.add((link, other))
        both_links = [(a.a, a.b) for a in self._cell.allowed_pairs]
        for link, other in [*both_links, *rigid_pairs(self._cell.robot)]:
            if engine.has_link(robot, link) and engine.has_link(robot, other):
                engine.set_collision(robot, link, robot, other, on=False)
                pairs |= {(link, other), (other, link)}
        return pairs

    def let_through(self, grip: Grip) -> None:
        """No physics between what holds and its item until they are apart: it would throw the item off.

        Args:
            grip: What holds, before a step.
        """
        wanted = frozenset({grip.attached} if grip.attached is not None else ())
        if not wanted and not self.let_go_through:
            return
        for name in sorted(wanted - self.let_go_through):
            self._set_collision(name, on=False)
        apart = {name for name in sorted(self.let_go_through - wanted) if grip.is_apart(name)}
        for name in sorted(apart):
            self._set_collision(name, on=True)
        self.let_go_through = (self.let_go_through | wanted) - apart

    def _set_collision(self, item: str, on: bool) -> None:
        for link in self._cell.robot.tool.contact_links:
            self._engine.set_collision(self._robot, link, item, "", on=on)
