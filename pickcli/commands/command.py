"""What every subcommand is: a click command that takes each option once, and with --json answers in JSON."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import asdict
from typing import Any

import click

from pickcli.errors import ApcError, NoPlanError, RejectedError

_RESULT = f"{__name__}.result"  # where a result waits in a click context until its command ends
_ORDER = f"{__name__}.order"  # where a click context has the parameters as they were given


def _is_told_once(option: click.Option) -> bool:
    """Whether an option has one value, so that a second one would silently replace the first."""
    return not option.is_flag and not option.multiple


class Terminated(KeyboardInterrupt):
    """SIGTERM, which ends a command as Ctrl-C does: so that it can say what is kept and how it goes on."""


class Command(click.Command):
    """A command that refuses an option which is given twice, where click would take the last.

    With --json it prints one object in the end, whether it succeeds or not.
    """

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Read the words of the command line.

        Args:
            ctx: Context of click.
            args: The words.

        Returns:
            Words that are left.

        Raises:
            UsageError: An option with a value is given twice, or anything that click refuses.
            InputError: A value is refused.
        """
        is_json = "--json" in args  # which click takes the words from
        try:
            _, _, order = self.make_parser(ctx).parse_args(args=list(args))
            ctx.meta[_ORDER] = [parameter.name for parameter in order]
            for parameter, times in Counter(order).items():
                if isinstance(parameter, click.Option) and _is_told_once(parameter) and times > 1:
                    raise click.UsageError(f"{_given(parameter, times, args)}; keep one", ctx)
            return super().parse_args(ctx, args)
        except (ApcError, click.UsageError) as error:
            if is_json:
                _print(ctx, error)
            raise

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command.

        Args:
            ctx: Context of click, with the values of the parameters.

        Returns:
            What the command returns.

        Raises:
            ApcError: The command failed.
            UsageError: Its options contradict each other.
            KeyboardInterrupt: It was interrupted.
        """
        is_json = bool(ctx.params.get("as_json"))
        try:
            returned = super().invoke(ctx)
        except (ApcError, click.UsageError, KeyboardInterrupt) as error:
            if is_json:
                _print(ctx, error)
            raise
        if is_json:
            _print(ctx)
        return returned


def _given(option: click.Option, times: int, words: Sequence[str]) -> str:
    """How an option is given more than once among the words of a command line, by whichever of its names."""
    names = [name for name in option.opts if any(word.partition("=")[0] == name for word in words)]
    if len(names) > 1:
        return f"{' and '.join(names)} mean the same"
    return f"{option.opts[-1]} is given {times} times"


def in_order_given(**values: Sequence[str]) -> list[tuple[str, str]]:
    """Tell in which order the values of several options that may be repeated were given.

    Args:
        **values: Values of each by the name of its parameter.

    Returns:
        Names and values, as they stand on the command line.
    """
    left = {name: iter(given) for name, given in values.items()}
    order = click.get_current_context().meta[_ORDER]
    return [(name, next(left[name])) for name in order if name in left]


def emit_json(value: dict[str, Any]) -> None:
    """Answer with one JSON object, printed when the command ends: with what went wrong then, if anything did.

    Args:
        value: JSON values, in the order in which they are to be told.
    """
    click.get_current_context().meta[_RESULT] = value


def exit_code(error: BaseException) -> int:
    """The exit code of a command that ends by an exception.

    Args:
        error: One of those that are no bug.

    Returns:
        As docs/reference/errors.md says.
    """
    if isinstance(error, KeyboardInterrupt):
        return 143 if isinstance(error, Terminated) else 130
    return error.exit_code if isinstance(error, ApcError | click.ClickException) else 1


def _print(ctx: click.Context, error: BaseException | None = None) -> None:
    """Print what a command found out and what went wrong: the latter counts, if stdout takes neither."""
    head = {"command": ctx.info_name, "exit_code": 0 if error is None else exit_code(error)}
    told = {**head, "error": None if error is None else _told(error), **ctx.meta.get(_RESULT, {})}
    text = json.dumps(told, indent=2, allow_nan=False)
    if error is None:
        click.echo(text)
    else:
        with suppress(OSError):
            click.echo(text)


def how_to_go_on(stop: KeyboardInterrupt) -> str:
    """Say how an interrupted command goes on.

    Args:
        stop: The interruption, with what was noted on its way up (``add_note``), if anything was kept.

    Returns:
        The notes, else that the command begins again.
    """
    return "\n".join(getattr(stop, "__notes__", ())) or "the same command begins again"


def _told(error: BaseException) -> dict[str, Any]:
    """What went wrong, as JSON values."""
    reasons = error.reasons if isinstance(error, NoPlanError | RejectedError) else ()
    if isinstance(error, KeyboardInterrupt):
        message = how_to_go_on(error)
    else:
        message = error.format_message() if isinstance(error, click.ClickException) else str(error)
    return {
        "kind": type(error).__name__,
        "message": message,
        "reasons": [asdict(reason) for reason in reasons],
    }
