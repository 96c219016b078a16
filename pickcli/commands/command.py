"""Base class of all subcommands: a click command that accepts each option once, with JSON output."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import asdict
from typing import Any

import click

from pickcli.commands.options.option_types import RenamedOption
from pickcli.errors import ApcError, NoPlanError, RejectedError

_RESULT = f"{__name__}.result"  # key of the result in a click context until its command ends
_ORDER = f"{__name__}.order"  # key of the parameters in their given order in a click context


def _is_single(option: click.Option) -> bool:
    """Whether an option has one value, so that a repetition would silently replace it."""
    return not option.is_flag and not option.multiple


class Terminated(KeyboardInterrupt):
    """SIGTERM, which ends a command like Ctrl-C, so that it can print how to continue."""


class Command(click.Command):
    """A command that refuses repeated options, of which click would use the last.

    With --json it prints one object at the end, whether it succeeds or not.
    """

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Parse the words of the command line.

        Args:
            ctx: Context of click.
            args: The words.

        Returns:
            Remaining words.

        Raises:
            UsageError: An option with a value is repeated, or click refuses the command line.
            InputError: A value is refused.
        """
        is_json = "--json" in args  # before click consumes the words
        try:
            _, _, order = self.make_parser(ctx).parse_args(args=list(args))
            ctx.meta[_ORDER] = [parameter.name for parameter in order]
            for parameter, times in Counter(order).items():
                if isinstance(parameter, click.Option) and _is_single(parameter) and times > 1:
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
            The command's return value.

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
    """Describe how an option is repeated in the words of a command line, by the names that were used."""
    known = (*option.opts, *(option.old if isinstance(option, RenamedOption) else ()))
    names = [name for name in known if any(word.partition("=")[0] == name for word in words)]
    if len(names) > 1:
        return f"{' and '.join(names)} mean the same"
    return f"{names[0] if names else option.opts[-1]} is given {times} times"


def in_order_given(**values: Sequence[str]) -> list[tuple[str, str]]:
    """Return the values of several repeatable options in the order in which they were given.

    Args:
        **values: Values of each option, by the name of its parameter.

    Returns:
        Pairs of name and value, in the order of the command line.
    """
    left = {name: iter(given) for name, given in values.items()}
    order = click.get_current_context().meta[_ORDER]
    return [(name, next(left[name])) for name in order if name in left]


def emit_json(value: dict[str, Any]) -> None:
    """Set the JSON object to be printed when the command ends, together with its error, if any.

    Args:
        value: JSON values, in the order of printing.
    """
    click.get_current_context().meta[_RESULT] = value


def exit_code(error: BaseException) -> int:
    """Return the exit code of a command that ends with an exception.

    Args:
        error: An exception that does not indicate a bug.

    Returns:
        The code, as in docs/reference/errors.md.
    """
    if isinstance(error, KeyboardInterrupt):
        return 143 if isinstance(error, Terminated) else 130
    return error.exit_code if isinstance(error, ApcError | click.ClickException) else 1


def _print(ctx: click.Context, error: BaseException | None = None) -> None:
    """Print result and error as JSON; an error takes precedence over a stdout that cannot be written."""
    head = {"command": ctx.info_name, "exit_code": 0 if error is None else exit_code(error)}
    values = {**head, "error": None if error is None else _error_values(error), **ctx.meta.get(_RESULT, {})}
    text = json.dumps(values, indent=2, allow_nan=False)
    if error is None:
        click.echo(text)
    else:
        with suppress(OSError):
            click.echo(text)


def how_to_go_on(stop: KeyboardInterrupt) -> str:
    """Describe how to continue an interrupted command.

    Args:
        stop: The interruption, with notes (``add_note``) if results were kept.

    Returns:
        The notes, else a statement that the command starts over.
    """
    return "\n".join(getattr(stop, "__notes__", ())) or "the same command starts over"


def _error_values(error: BaseException) -> dict[str, Any]:
    """Convert an error to JSON values."""
    reasons = error.reasons if isinstance(error, NoPlanError | RejectedError) else ()
    if isinstance(error, KeyboardInterrupt):
        message = how_to_go_on(error)
    else:
        message = error.format_message() if isinstance(error, click.ClickException) else str(error)
    return {
        "kind": type(error).__name__,
        "message": message,
        "reasons": [asdict(reason) for reason in reasons],
        "blockers": list(error.blockers) if isinstance(error, NoPlanError) else [],
    }
