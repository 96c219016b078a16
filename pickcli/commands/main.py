"""``apc``: the group of all subcommands, loaded only when called so that ``apc --help`` is instant."""

from __future__ import annotations

import importlib
import sys

import click

from pickcli import __version__
from pickcli.errors import ApcError

# name -> what it does, in one line. The command lives in pickcli.commands.<name with underscores>
# as an object called ``command``.
COMMANDS: dict[str, str] = {
    "build-roadmap": "Offline: KTH's roadmap of the named configurations.",
    "build-trajectories": "Offline: Delft's database of coarse motions.",
    "suggest-configurations": "Rank configurations in front of a bin by what can be reached from them.",
    "compare-planners": "Let planners compete over the same pairs: time, length, duration, share solved.",
    "make-order": "Draw a fresh order by the official rules.",
    "make-scene": "Place the items of an order in their bins, at rest.",
    "plan-pick": "Plan one pick, from leaving for the bin to the item in the tote, or in another bin.",
    "plan-move": "Plan a move between two configurations.",
    "verify": "Let the independent verifier check a plan.",
    "execute": "Run a plan in pybullet.",
    "run-trial": "Play a whole order by the rules and keep score.",
    "check": "Find damage in a roadmap or trajectory database.",
    "refresh": "Make a roadmap or trajectory database right for a cell that changed.",
    "inspect": "Show what is in a roadmap, database, plan, scene or cell.",
}


class LazyGroup(click.Group):
    """A click group that imports a subcommand's module only when that subcommand is used."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Names in the order of use."""
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import and return one command; None for an unknown name."""
        if cmd_name not in COMMANDS:
            return None
        module = importlib.import_module(f"pickcli.commands.{cmd_name.replace('-', '_')}")
        command = module.command
        assert isinstance(command, click.Command)
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """The list in ``apc --help``, without importing anything."""
        with formatter.section("Commands"):
            formatter.write_dl(list(COMMANDS.items()))


@click.group(cls=LazyGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="apc")
def apc() -> None:
    """Proven picking motion for a robot arm in front of a shelf.

    \b
    Example:
      apc make-scene jsk_pick_sample --seed 3 -o scene.json
      apc plan-pick --scene scene.json --bin bin_C --item NAME -o plan.json
      apc execute plan.json --scene scene.json
    """


def main() -> None:
    """Entry point: maps every outcome to its exit code (docs/commands.md)."""
    try:
        code = apc.main(standalone_mode=False)
    except click.UsageError as error:
        error.show()
        sys.exit(2)
    except click.Abort:
        click.echo("interrupted", err=True)
        sys.exit(130)
    except KeyboardInterrupt:
        click.echo("interrupted", err=True)
        sys.exit(130)
    except click.ClickException as error:
        error.show()
        sys.exit(3)
    except ApcError as error:
        click.echo(f"apc: error: {error}", err=True)
        sys.exit(error.exit_code)
    except BrokenPipeError:
        sys.exit(0)
    sys.exit(code if isinstance(code, int) else 0)


if __name__ == "__main__":
    main()
