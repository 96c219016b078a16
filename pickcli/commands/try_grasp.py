"""``apc try-grasp``: grasps of a hand with belts, in simulation."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from pickcli.commands.command import Command, emit_json
from pickcli.commands.options.common_options import json_option, seed_option
from pickcli.commands.options.option_types import FiniteRange
from pickcli.commands.output.progress_bar import progress
from pickcli.errors import UnknownNameError
from pickcli.progress import Progress

if TYPE_CHECKING:
    from pickcli.hand.belt_hand import BeltHand, GraspObject
    from pickcli.hand.grasp_trial import GraspTrial, PreGrasp

MOST_GRASPS = 1000
GRASPS = 10  # with --poses, unless stated
POSES = ("grid", "near", "rectangular", "random")  # those of pickcli.hand.pre_grasps, which is slow to import
OFFSET, TILT = FiniteRange(-0.1, 0.1), FiniteRange(-0.5, 0.5)


@click.command("try-grasp", cls=Command)
@click.argument("hand_name", metavar="HAND")
@click.option("--object", "object_name", metavar="OBJECT", required=True,
              help="Object to grasp, one of the hand's file.")  # fmt: skip
@click.option("--offset", type=(OFFSET, OFFSET, OFFSET), metavar="X Y Z", default=None,
              help="Offset of the hand, m along the approach, left and up.  [default: 0 0 0]")  # fmt: skip
@click.option("--tilt", type=(TILT, TILT), metavar="ROLL PITCH", default=None,
              help="Tilt of the hand, rad.  [default: 0 0]")  # fmt: skip
@click.option("--poses", type=click.Choice(POSES), default=None,
              help="Draw many grasps: in a grid about an object, near it, or before a cluster.")  # fmt: skip
@click.option("--grasps", type=click.IntRange(1, MOST_GRASPS), metavar="N",
              help="Number of grasps with --poses.  [default: 10]")  # fmt: skip
@seed_option
@json_option
def command(
    hand_name: str, object_name: str, offset: tuple[float, float, float] | None,
    tilt: tuple[float, float] | None, poses: str | None, grasps: int | None, seed: int, as_json: bool,
) -> None:  # fmt: skip
    """Grasp an object with a hand with belts in simulation, and show how each stage went.

    HAND is a name under data/hands or a file. Without --poses one grasp of an object that stands alone is
    played, and told stage by stage. With it many are, with noise from the seed, and counted by their ends.

    \b
    Example:
      apc try-grasp apple --object can --offset 0.02 -0.03 0
      apc try-grasp apple --object coke --poses rectangular --grasps 5 --seed 3
    """
    from pickcli.hand.grasp_figures import grasp_as_json, grasp_figures
    from pickcli.hand.grasp_trial import play_grasp
    from pickcli.hand.hand_file import hand_file, read_hand

    if poses is not None and (offset is not None or tilt is not None):
        raise click.UsageError("--poses draws offsets and tilts; leave out --offset and --tilt, or --poses")
    if poses is None and grasps is not None:
        raise click.UsageError("--grasps is the number of grasps of --poses; name these, or leave it out")
    hand = read_hand(hand_file(hand_name))
    if object_name not in hand.objects:
        raise UnknownNameError("object", object_name, list(hand.objects), f"hand {hand.name}")
    kind = hand.objects[object_name]
    aside = (*(offset or (0.0,) * 3), *(tilt or (0.0,) * 2))
    drawn = _drawn(hand, kind, poses, grasps or GRASPS, seed, aside)
    trials = []
    with progress("grasps") as show:
        for k, each in enumerate(drawn):
            show(Progress(k, len(drawn), kind.name))
            trials.append(play_grasp(hand, kind, each))
    figures = grasp_figures(trials)
    if as_json:
        emit_json(
            {"hand": hand.name, "object": kind.name, **figures, "trials": [*map(grasp_as_json, trials)]}
        )
    elif poses is None:
        _print_stages(trials[0])
    else:
        ends = ", ".join(f"{n} {end}" for end, n in figures["ends"].items())
        click.echo(
            f"{kind.name}, {poses}: {figures['lifted']} of {figures['grasps']} lifted ({ends}), "
            f"{figures['enveloping']} enveloping, {figures['separated']} with a separation; approach "
            f"{figures['approach_time']:.1f} s, grasp {figures['execution_time']:.1f} s in the mean; at most "
            f"{figures['most_force']:.0f} N on a pad"
        )


def _drawn(
    hand: BeltHand, kind: GraspObject, poses: str | None, grasps: int, seed: int, offset: tuple[float, ...]
) -> list[PreGrasp]:
    import numpy as np

    from pickcli.hand.pre_grasps import GraspPoses, pre_grasps, single_grasp

    if poses is None:
        return [single_grasp(hand, kind, np.array(offset))]
    return pre_grasps(hand, kind, GraspPoses(poses), grasps, seed)


def _print_stages(trial: GraspTrial) -> None:
    from pickcli.commands.output.table import table_lines

    head = ("stage", "from, s", "to, s", "ended by", "current, A", "fingers, rad", "blocked", "slipping")
    rows = [
        (
            stage.name.value, f"{stage.start:.2f}", f"{stage.end:.2f}", stage.ended_by,
            f"{stage.current:.2f}", f"{stage.angle:.3f}",
            *(", ".join(n.replace("_", " ") for n in each) for each in (stage.blocked, stage.slipping)),
        )
        for stage in trial.stages
    ]  # fmt: skip
    envelops = ", enveloped by the fingers" if trial.is_enveloping else ""
    told = f"{trial.end.value}{envelops}; at most {trial.most_force:.1f} N on a pad"
    click.echo("\n".join([*table_lines(head, rows), told]))
