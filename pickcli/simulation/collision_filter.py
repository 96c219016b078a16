"""Pairs that the physics lets pass through each other: allowed pairs, and the tool with its attached item."""

from __future__ import annotations

from itertools import product

from pickcli.scene.scene import Scene
from pickcli.simulation.engine import Engine
from pickcli.simulation.grip import Grip
from pickcli.simulation.scene_bodies import jointed_pairs, rigid_pairs, standing_links


class CollisionFilter:
    """Collision filter of one robot.

    Attributes:
        exempt: Pairs (link, body or other link) that never count as contacts: pairs that the cell allows,
            links without relative motion, and links that a joint connects. Pairs of stationary links and
            bodies are included, as their contact moves nothing.
        let_go_through: Names of items without collision physics with the contact links at present.

    Args:
        engine: The engine with the robot and the items.
        robot: Name of the robot's body.
        scene: The scene, with the cell as seen by the moving arm.
    """

    def __init__(self, engine: Engine, robot: str, scene: Scene) -> None:
        self._engine, self._robot, self._cell = engine, robot, scene.cell
        self.let_go_through: frozenset[str] = frozenset()
        standing = (body.name for body, _ in scene.standing)
        self.exempt = frozenset(product(standing_links(scene.cell.robot), standing)) | self._switched_off()

    def _switched_off(self) -> set[tuple[str, str]]:
        """Disable the physics of pairs that may overlap, and return them."""
        engine, robot, pairs = self._engine, self._robot, set[tuple[str, str]]()
        allowed_pairs = [pair for pair in self._cell.allowed_pairs if not pair.verified]
        for allowed in allowed_pairs:
            for link, other in ((allowed.a, allowed.b), (allowed.b, allowed.a)):
                if engine.has_link(robot, link) and engine.has_body(other):
                    engine.set_collision(robot, link, other, "", on=False)
                    pairs.add((link, other))
        both_links = [(a.a, a.b) for a in allowed_pairs]
        robot_pairs = [*rigid_pairs(self._cell.robot), *jointed_pairs(self._cell.robot)]
        for link, other in [*both_links, *robot_pairs]:
            if engine.has_link(robot, link) and engine.has_link(robot, other):
                engine.set_collision(robot, link, robot, other, on=False)
                pairs |= {(link, other), (other, link)}
        return pairs

    def let_through(self, grip: Grip) -> None:
        """Disable the physics between grip and attached item until they separate: it would eject the item.

        Args:
            grip: The grip, before a step.
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
