"""What every subcommand is: a click command that takes each option once."""

from __future__ import annotations

from collections import Counter

import click


class Command(click.Command):
    """A command that refuses an option which is given twice, where click would take the last."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Read the words of the command line.

        Args:
            ctx: Context of click.
            args: The words.

        Returns:
            Words that are left.

        Raises:
            UsageError: An option with a value is given twice.
        """
        _, _, order = self.make_parser(ctx).parse_args(args=list(args))
        for parameter, times in Counter(order).items():
            if isinstance(parameter, click.Option) and not parameter.is_flag and times > 1:
                raise click.UsageError(f"{parameter.opts[-1]} is given {times} times; keep one", ctx)
        return super().parse_args(ctx, args)
