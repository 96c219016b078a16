"""``apc``: the group of all subcommands, loaded only when called so that ``apc --help`` is instant."""

from __future__ import annotations

import importlib
import io
import logging
import os
import re
import signal
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from typing import TextIO

import click
from click.exceptions import Exit

from pickcli import __version__
from pickcli.commands.command import Terminated, exit_code, how_to_go_on
from pickcli.commands.logs import hide, log_options, show_warnings
from pickcli.errors import ApcError, printable
from pickcli.name_suggestion import suggestion

_log = logging.getLogger(__name__)

# Name -> one-line description. The command is the object ``command`` in the module
# pickcli.commands.<name with underscores>.
COMMANDS: dict[str, str] = {
    "init": "Write a cell for a robot, from its URDF.",
    "build-roadmap": "Offline: KTH's roadmap of the named configurations.",
    "build-trajectories": "Offline: Delft's database of coarse motions.",
    "suggest-configurations": "Rank configurations in front of a bin by what can be reached from them.",
    "suggest-mount": "Rank base poses of the robot by the share of tool poses that it reaches from them.",
    "compare-planners": "Compare planners on the same queries: time, length, duration, share solved.",
    "record-grasp": "Record a grasp of an item: from a verified plan, or as stated.",
    "make-order": "Draw a random order by the official rules.",
    "make-scene": "Place items in bins and other places, at rest.",
    "make-stream": "Draw a random stream: items that come along a conveyor.",
    "roll-out": "Let a controller bring the tool into an envelope of an item, and show how its tasks fare.",
    "try-grasp": "Grasp an object with a hand with belts in simulation, and show how each stage went.",
    "render": "Render what a camera of the cell sees of a scene.",
    "locate-pod": "Estimate where the pod stands from one depth picture, with bounds of the error.",
    "locate-tote": "Locate the tote by touching its walls and its rim with the cup, in simulation.",
    "perceive": "Find the listed items of bins in pictures of a camera.",
    "show-routes": "Tell by what apc perceive would look for items, without looking.",
    "believe": "Make the scene that a planner believes in from what was perceived.",
    "plan-pick": "Plan one pick: take an item, and bring it to the tote or to another place.",
    "plan-shift": "Plan one shift: move an item within its bin, lifted a little.",
    "plan-topple": "Plan a push that topples an item in a box or bin, or pushes it off others.",
    "plan-stow": "Plan one stow: take an item out of the tote, and set it down in a bin.",
    "make-pallet-order": "Draw a random order of cartons on a pallet.",
    "plan-pallet": "Plan where each carton of an order stands on its pallet, and in which sequence.",
    "detect-pallet": "Find the pallet that an area expects in one depth picture, with bounds of the error.",
    "plan-drive": "Plan how a truck drives from its start to its goal, past everything.",
    "watch-zone": "Play a drive past people, and report whom the truck sees and when it brakes.",
    "plan-move": "Plan a move between two configurations.",
    "verify": "Check a plan, a stacked pallet or a drive with the independent verifier.",
    "execute": "Execute a plan in pybullet or with another driver, or plan and execute queries.",
    "check-driver": "Execute a plan by a driver, and check that the driver keeps to the protocol.",
    "export": "Write a verified plan for a robot or for other tools.",
    "run-trial": "Play a whole order in simulation, by the rules, and score it.",
    "explain-stow": "Show which bin is assigned to each item of a stow order, and why.",
    "run-trials": "Play orders with many seeds, and report the distribution of scores.",
    "compare-trials": "Compare two folders of trials, and test whether the difference is more than chance.",
    "check": "Find mistakes in a cell, scene, order, driving area or items, or damage in a stored file.",
    "refresh": "Update a roadmap or trajectory database for a cell that changed.",
    "cache": "Show what is in the cache of built files, or delete it.",
    "show": "Make a page that shows a cell, scene, plan, trial, roadmap or database in 3-D.",
    "show-strategy": "Show the behaviour tree by which trials are played, or list the strategies.",
    "show-grasps": "Make a page of an item with its regions and candidate grasps.",
    "show-envelope": "Make a page of the envelopes of an item: poses from which the tool can grasp it.",
    "import-tsr": "Convert KTH's task space regions to a file of items.",
    "inspect": "Show what is in a roadmap, database, plan, scene, stream, cell, pallet or perceived items.",
}


class LazyGroup(click.Group):
    """A click group that imports a subcommand's module only when that subcommand is used."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """List the commands.

        Args:
            ctx: Context of click.

        Returns:
            Names in the order of use.
        """
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import one command.

        Args:
            ctx: Context of click.
            cmd_name: Name of the command.

        Returns:
            The command; None for an unknown name.
        """
        if cmd_name not in COMMANDS:
            return None
        module = importlib.import_module(f"pickcli.commands.{cmd_name.replace('-', '_')}")
        command = module.command
        assert isinstance(command, click.Command)
        if not any(parameter.name == "verbose" for parameter in command.params):
            command.params += log_options()
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the command that the first word names.

        Args:
            ctx: Context of click.
            args: Words of the command line.

        Returns:
            Name and command, and the remaining words.

        Raises:
            UsageError: There is no such command; with a suggestion.
        """
        if args and args[0] not in COMMANDS and not args[0].startswith("-"):
            ctx.fail(f"unknown command {args[0]!r}; {suggestion(args[0], COMMANDS)}")
        return super().resolve_command(ctx, args)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the list in ``apc --help``, without importing anything.

        Args:
            ctx: Context of click.
            formatter: Formatter that the list is written to.
        """
        with formatter.section("Commands"):
            formatter.write_dl(list(COMMANDS.items()))


@click.group(cls=LazyGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="apc")
def apc() -> None:
    """Proven picking motion for one robot arm or two, at shelves, crates and tables.

    \b
    Example:
      apc make-scene jsk_pick_sample --seed 3 -o scene.json
      apc plan-pick --scene scene.json --bin bin_A --item kleenex_tissue_box -o plan.json
      apc execute plan.json --scene scene.json
    """


apc.params += log_options()


def main() -> None:
    """Entry point: maps every outcome to its exit code (docs/commands.md)."""
    _open_closed_streams()
    _buffer_stdout()
    with suppress(AttributeError):  # not every stream can be reconfigured
        sys.stdout.reconfigure(errors="backslashreplace")  # type: ignore[union-attr]
    show_warnings()
    before, began = signal.signal(signal.SIGTERM, _terminate), time.perf_counter()
    try:
        code = _flushed(_outcome())
        _log.info("exit code %d after %.3f s", code, time.perf_counter() - began)
    except KeyboardInterrupt as stop:  # after the command was done
        code = _stopped(stop)
    finally:
        signal.signal(signal.SIGTERM, before)
        hide()
    sys.exit(code)


def _open_closed_streams() -> None:
    """Open streams that the caller closed (``>&-``); else the next opened file would get their numbers.

    Writing to such a stdout fails then, as on a full disk; if stderr is closed, messages are lost.
    """
    for name, flags, mode in (
        ("stdin", os.O_RDONLY, "r"),
        ("stdout", os.O_RDONLY, "w"),
        ("stderr", os.O_WRONLY, "w"),
    ):
        if getattr(sys, name) is None:
            handle = os.open(os.devnull, flags)  # gets the lowest free number: the stream's own
            os.set_inheritable(handle, True)
            setattr(sys, name, os.fdopen(handle, mode, encoding="utf-8"))


def _buffer_stdout() -> None:
    """Add a line buffer to an unbuffered stdout (PYTHONUNBUFFERED, as in many containers).

    Without one, Python silently drops the rest of a text that a full disk accepted in part.
    """
    if isinstance(raw := getattr(sys.stdout, "buffer", None), io.RawIOBase):
        sys.stdout = os.fdopen(raw.fileno(), "w", 1, sys.stdout.encoding, closefd=False)


def _terminate(*_: object) -> None:
    signal.signal(signal.SIGTERM, signal.SIG_DFL)  # a second signal ends the process at once
    raise Terminated


def _outcome() -> int:
    """Run the command. Returns its exit code."""
    if "_APC_COMPLETE" in os.environ:  # a shell requests completions
        apc.main(prog_name="apc")
    try:
        with apc.make_context("apc", sys.argv[1:]) as context:
            code = apc.invoke(context)
    except Exit as done:  # --help, --version
        return done.exit_code
    except click.UsageError as error:
        _tell(_with_help(error).show)
        return 2
    except KeyboardInterrupt as stop:
        return _stopped(stop)
    except click.ClickException as error:
        _tell(error.show)
        return 3
    except ApcError as error:
        _log.debug("raised here", exc_info=error)
        for note in getattr(error, "__notes__", ()):  # e.g. of a build on a full disk
            _say(note)
        _say(f"apc: error: {printable(str(error))}")
        return error.exit_code
    except BrokenPipeError:  # the reader has closed the pipe
        _give_up(sys.stdout)
        return 0
    except OSError as error:  # a full disk, a name that is too long: not a bug
        where = error.filename if error.filename is not None else "output"
        if error.filename is None:
            _give_up(sys.stdout)
        _say(f"apc: error: {printable(str(where))}: {error.strerror}")
        return 3
    return code if isinstance(code, int) else 0


def _stopped(stop: KeyboardInterrupt) -> int:
    """Print how to continue an interrupted command."""
    _say(how_to_go_on(stop))
    _say("terminated" if isinstance(stop, Terminated) else "interrupted")
    return exit_code(stop)


def _with_help(error: click.UsageError) -> click.UsageError:
    """Return the error; for a missing parameter with its help, or an example of the command."""
    if not isinstance(error, click.MissingParameter) or error.param is None or error.ctx is None:
        return error
    if isinstance(error.param, click.Option):
        text = f"{error.param.make_metavar(error.ctx)}: {error.param.help}"
    else:
        example = re.search(r"Example:\s+(apc .*)", error.ctx.command.help or "")
        text = "" if example is None else f"Example: {example[1]}"
    return click.MissingParameter(text, error.ctx, error.param)


def _flushed(code: int) -> int:
    """Flush stdout and return the exit code, 3 if that fails."""
    try:
        sys.stdout.flush()
    except BrokenPipeError:
        _give_up(sys.stdout)
    except OSError as error:
        _give_up(sys.stdout)
        _say(f"apc: error: output: {error.strerror}")
        return code or 3
    return code


def _say(text: str) -> None:
    """Print a line on stderr."""
    _tell(lambda: click.echo(text, err=True))


def _tell(write: Callable[[], None]) -> None:
    """Write a message to stderr. On a full disk it is lost, as if stderr were closed: the exit code tells."""
    try:
        write()
    except OSError:
        _give_up(sys.stderr)


def _give_up(stream: TextIO) -> None:
    """Redirect a stream to nowhere, so that the interpreter does not try to write the rest at exit."""
    with suppress(OSError, ValueError):
        null = os.open(os.devnull, os.O_WRONLY)
        os.dup2(null, stream.fileno())
        os.close(null)


if __name__ == "__main__":
    main()
