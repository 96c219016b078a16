"""Roll-outs into envelopes: in which order they are tried, which is chosen, and from where they go on."""

from __future__ import annotations

import numpy as np
import pytest

from pickcli.cell.cell_file import load_cell
from pickcli.control.roll_out import End, RollOut
from pickcli.geometry import Array
from pickcli.grasping.envelope import Envelope
from pickcli.planning.envelope_roll_outs import MOST_ROUNDS, best_of, roll_out_into
from support.cans import CanScene, can

HOME = np.zeros(2)


@pytest.fixture(scope="module")
def scene() -> CanScene:
    table = load_cell("panda_table")
    return CanScene(table, (can(table, "n", 0.46, 0.2),))


class Controller:
    """Moves by a step in every run; it reaches what it is told to, and leaves less each time."""

    def __init__(self, reaches: dict[int, float]) -> None:
        self.reaches, self.starts = reaches, list[Array]()

    def run(self, envelope: Envelope, start: Array, rates: Array) -> RollOut:
        assert not rates.any()
        k = len(self.starts)
        self.starts.append(start)
        reached, way = k in self.reaches, self.reaches.get(k, 1.0)
        Q = start + np.array([[0.0, 0.0], [way, 0.0], [way, 0.0]])  # at rest at its end
        errors = {"envelope": np.array([9.0, 9.0, 0.0 if reached else 1.0 / (k + 1)])}
        return RollOut(End.REACHED if reached else End.LOCAL_MINIMUM, Q, errors, np.zeros((2, 1)), 0.01)


def test_of_whole_envelopes_that_are_reached_the_shortest_way_is_kept(scene: CanScene) -> None:
    controller = Controller({0: 3.0, 1: 2.0})
    envelopes, T = scene.envelopes[:2], scene.target.T_world_item
    ended = roll_out_into(controller.run, "envelope", HOME, envelopes, T, scene.tool)
    assert [each.envelope for each in ended] == list(envelopes)  # nothing is divided
    best = best_of(ended)
    assert best is ended[1] and best.travel == 2.0 and best.is_reached


def test_where_none_is_reached_it_goes_on_from_where_it_came_the_nearest(scene: CanScene) -> None:
    envelopes, T = scene.envelopes[:2], scene.target.T_world_item
    never = roll_out_into(Controller({}).run, "envelope", HOME, envelopes, T, scene.tool)
    n = len(never) // MOST_ROUNDS
    assert len(never) == MOST_ROUNDS * n and n > 4
    assert [each.envelope for each in never[:2]] == list(envelopes)
    controller = Controller({n + 1: 0.5})
    ended = roll_out_into(controller.run, "envelope", HOME, envelopes, T, scene.tool)
    assert len(ended) == n + 2
    assert all((start == HOME).all() for start in controller.starts[:n])
    nearest = best_of(ended[:n]).run
    assert (controller.starts[n] == nearest.Q[-1]).all()
    joined = best_of(ended).run
    np.testing.assert_array_equal(joined.Q, [*nearest.Q, *[nearest.Q[-1] + np.array([0.5, 0.0])] * 2])
    assert len(joined.errors["envelope"]) == len(joined.Q) == len(joined.slack) + 1
    assert joined.end is End.REACHED and joined.duration == pytest.approx(0.04)
