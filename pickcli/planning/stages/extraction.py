"""Extraction of one item from a bin: a few simple ways out first, more if no grasp can follow those.

They are found for the item as a free flyer, so that a buried item fails before any grasp is tried.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum
from functools import cached_property, partial

import numpy as np

from pickcli.cartesian.corridor import RETREAT_DISTANCE, Corridor, corridor_transforms, corridors
from pickcli.cell.place import Place
from pickcli.cell.shapes import Shape
from pickcli.collision.free_flyer import FreeItem, FreeItemChecker
from pickcli.collision.stage_contacts import PickContacts
from pickcli.errors import Failures
from pickcli.geometry import Array
from pickcli.planning.pick_problem import PickProblem, once_per_problem
from pickcli.planning.stages.planned_extraction import OUT_OF_OPEN_BOX, OUT_OF_SHELF, planned_corridors
from pickcli.seeds import derived_seed

N_FEW, N_MANY = 4, 40  # most simple ways out


class CorridorSet(Enum):
    """Size of the set of ways out that a grasp may choose from."""

    FEW = "the shortest simple ones"
    MANY = "all simple ones, and planned ones"


@dataclass(frozen=True, eq=False)
class Extraction:
    """Extraction of one item from one bin.

    Attributes:
        place: Place of the item.
        T_world_entry: (4, 4) frame of the way into the place, x pointing inwards.
        T_entry_item: (4, 4) pose of the item in that frame.
        shape: Shape of the item, enlarged by its uncertainty.
        leaving: Checker of the item in the first stretch, in which it may touch its support.
        carrying: Checker of the item after that, when it may touch nothing.
        first_stretch: m, length of the first stretch.
        seed: Seed of planned ways.
        sparing: The extraction without pushing, whose ways are preferred; None if the item may push nothing.
        further: m by which ways out of a place that is open above lead on upwards, over what is beside it.
    """

    place: Place
    T_world_entry: Array
    T_entry_item: Array
    shape: Shape
    leaving: FreeItemChecker
    carrying: FreeItemChecker
    first_stretch: float
    seed: int
    sparing: Extraction | None = None
    further: float = 0.0

    @cached_property
    def corridors(self) -> tuple[Corridor, ...] | Failures:
        """The ways out for the item as a free flyer: the shortest simple ones, else planned ones."""
        if self.sparing is not None and not isinstance(spared := self.sparing._simple(N_FEW), Failures):
            return self._led_on(spared)
        found = self._simple(N_FEW)
        return self._planned or found if isinstance(found, Failures) else self._led_on(found)

    def transforms(self, ways: CorridorSet) -> tuple[Array, ...] | Failures:
        """Return the displacements of each way out, as they move the tool.

        Args:
            ways: Set of ways to choose from.

        Returns:
            (K, 4, 4) for each way, as from ``corridor_transforms``; or why the item cannot leave even
            as a free flyer.
        """
        if isinstance(self.corridors, Failures):
            return self.corridors
        if ways is CorridorSet.FEW:
            return self._transforms(self.corridors)
        extractions = (self,) if self.sparing is None else (self.sparing, self)
        simple = [many for each in extractions if not isinstance(many := each._simple(N_MANY), Failures)]
        return self._transforms((*(way for many in simple for way in self._led_on(many)), *self._planned))

    def _transforms(self, ways: tuple[Corridor, ...]) -> tuple[Array, ...]:
        centre = (self.T_world_entry @ self.T_entry_item)[:3, 3]
        return tuple(corridor_transforms(way, self.T_world_entry, centre) for way in ways)

    def _simple(self, n_most: int) -> tuple[Corridor, ...] | Failures:
        """Find simple ways out for the item as a free flyer, the shortest first; or why there is none."""
        return corridors(
            self.place,
            self.T_entry_item,
            self.shape,
            self.leaving,
            self.carrying,
            self.first_stretch,
            n_most,
        )

    def _led_on(self, ways: tuple[Corridor, ...]) -> tuple[Corridor, ...]:
        """Return ways that end further outside; nothing but the arm is met up there."""
        if self.further == 0.0:
            return ways
        beyond = np.array([self.further, *np.zeros(5)])
        return tuple(replace(way, retreat=(*way.retreat[:-1], way.retreat[-1] - beyond)) for way in ways)

    @cached_property
    def _planned(self) -> tuple[Corridor, ...]:
        if self.sparing is not None:  # what is pushed may be anywhere but straight above
            return ()
        ways = OUT_OF_OPEN_BOX if self.place.access.is_from_above else OUT_OF_SHELF
        return planned_corridors(
            ways, self.T_entry_item, self.shape, self.leaving, self.carrying, self.first_stretch, self.seed
        )


@once_per_problem
def extraction_of(problem: PickProblem) -> Extraction:
    """Return the extraction of the target of a pick.

    Args:
        problem: The pick.

    Returns:
        The extraction, with the contacts allowed in the lift and after it.
    """
    if not problem.pushed:
        return replace(_extraction(problem, problem.contacts), further=problem.rise)
    return replace(
        _extraction(problem, problem.contacts),
        sparing=_extraction(problem, replace(problem.contacts, pushed=frozenset())),
        further=max(0.0, problem.above_pushed - RETREAT_DISTANCE),
    )


def _extraction(problem: PickProblem, contacts: PickContacts) -> Extraction:
    scene, uncertainty = problem.scene, problem.uncertainty
    item = problem.target.item
    free = FreeItem(item, problem.target.T_world_item, problem.T_world_entry[:3, :3], uncertainty)
    checker = partial(problem.context.checkers.item, scene, free)
    beside = tuple(map(checker, contacts.rolling_along()))
    return Extraction(
        problem.place,
        problem.T_world_entry,
        problem.T_entry_item,
        item.shape.inflated(uncertainty),
        leaving=checker(contacts.item_while_lifting(), beside),
        carrying=checker(contacts.while_carrying()),
        first_stretch=problem.context.settings.first_stretch,
        seed=derived_seed(problem.seed, "exit", problem.target.id),
    )
