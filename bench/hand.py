"""Grasps of the hand with belts, beside the figures that its paper reports.

    python -m bench.hand [--grid 526] [--near 100] [--clusters 25] [--seed 0]

The grid: two boxes, a spray bottle and a can, from poses within 10 x 8 x 4 cm with roll and pitch of 10
degrees either way, in all as many as --grid says. Near: the same objects, --near poses in all within 2 cm and
10 degrees, of which those count that end with the fingers around the object. Clusters: nine cans of one kind,
tightly packed, --clusters grasps for each of three kinds and two arrangements. Masses, friction and how
objects stand deviate from the file; of clusters the closest point and the direction to it are perceived with
noise. Time is simulated.
"""

from __future__ import annotations

import argparse
import time

from rich.console import Console
from rich.table import Table

from pickcli.hand.grasp_figures import grasp_figures
from pickcli.hand.grasp_trial import GraspTrial, play_grasp
from pickcli.hand.hand_file import hand_file, read_hand
from pickcli.hand.pre_grasps import GraspPoses, pre_grasps

SINGLE = ("box_45", "box_50", "spray_bottle", "can")
CLUSTERED = ("beer", "coke", "bull")
WIDTH = 150  # characters of the table


class Bench:
    """Plays grasps and keeps a table of their figures.

    Args:
        seed: Seed of all of them.
    """

    def __init__(self, seed: int) -> None:
        self.hand, self.seed = read_hand(hand_file("apple")), seed
        self.table = Table(
            "poses", "object", "lifted", "enveloping", "other ends", "approach, s", "grasp, s", "N"
        )

    def play(self, poses: GraspPoses, names: tuple[str, ...], count: int) -> None:
        """Play as many grasps in all, shared evenly, and add rows."""
        played: list[GraspTrial] = []
        for k, name in enumerate(names):
            share = count // len(names) + (k < count % len(names))
            kind, start = self.hand.objects[name], time.process_time()
            trials = [
                play_grasp(self.hand, kind, each)
                for each in pre_grasps(self.hand, kind, poses, share, self.seed)
            ]
            if trials:
                self.row(poses.value, name, trials)
                print(
                    f"{poses.value} {name}: {(time.process_time() - start) / share:.2f} s a grasp", flush=True
                )
            played += trials
        if played:
            self.row(poses.value, "all", played)
            Console(width=WIDTH).print(self.table)

    def row(self, poses: str, name: str, trials: list[GraspTrial]) -> None:
        """Add a row."""
        figures = grasp_figures(trials)
        n = figures["grasps"]
        ends = ", ".join(f"{k} {end}" for end, k in figures["ends"].items() if end != "lifted")
        if figures["separated"]:
            ends += f"; {figures['separated']} separated"
        self.table.add_row(
            poses, name, f"{figures['lifted']} of {n}, {figures['lifted'] / n:.1%}",
            f"{figures['enveloping']}, {figures['enveloping'] / n:.0%}", ends,
            f"{figures['approach_time']:.1f}", f"{figures['execution_time']:.1f}",
            f"{figures['most_force']:.0f}",
        )  # fmt: skip


def main() -> None:
    """Print a row for each object and set of poses."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--grid", type=int, default=526)
    parser.add_argument("--near", type=int, default=100)
    parser.add_argument("--clusters", type=int, default=25)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    bench = Bench(options.seed)
    bench.play(GraspPoses.GRID, SINGLE, options.grid)
    bench.play(GraspPoses.NEAR, SINGLE, options.near)
    for poses in (GraspPoses.RECTANGULAR, GraspPoses.RANDOM):
        bench.play(poses, CLUSTERED, options.clusters * len(CLUSTERED))


if __name__ == "__main__":
    main()
