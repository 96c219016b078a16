"""``apc show-strategy``: prints the tree of a strategy, or writes it as a drawing or for other tools."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from pickcli.commands.command import Command, emit_json
from pickcli.commands.options.common_options import json_option, refuse_output
from pickcli.commands.options.option_types import PATH, refuse_suffix
from pickcli.commands.output.table import table_lines

if TYPE_CHECKING:
    from pickcli.strategy.strategy_tree import Strategy


@click.command("show-strategy", cls=Command)
@click.argument("strategy_name", metavar="[NAME|FILE]", required=False)
@click.option("-o", "--output", type=PATH, metavar="FILE",
              help="Write a drawing (.svg) or XML of BehaviorTree.CPP 4 (.xml) instead of text.")  # fmt: skip
@click.option("--overwrite", is_flag=True, help="Replace an existing file.")
@json_option
def command(strategy_name: str | None, output: Path | None, overwrite: bool, as_json: bool) -> None:
    """Show the behaviour tree by which trials are played, or list the strategies.

    In the text, conditions begin with a question mark, actions with an exclamation mark. The format of
    strategy files and all nodes: docs/formats/strategy.md.

    \b
    Example:
      apc show-strategy delft
      apc show-strategy kth -o kth.svg
    """
    from pickcli.strategy.node_types import TrialKind
    from pickcli.strategy.strategy_file import find_strategy, load_strategy, packaged_strategies
    from pickcli.strategy.strategy_text import strategy_text

    if strategy_name is None:
        if output is not None:
            raise click.UsageError("-o writes one strategy: name it, e.g. apc show-strategy kth -o kth.svg")
        named = [load_strategy(name, kind) for kind in TrialKind for name in packaged_strategies(kind)]
        if as_json:
            emit_json({"strategies": {each.name: each.description for each in named}})
        else:
            rows = [(each.name, each.description) for each in named]
            click.echo("\n".join(table_lines(("strategy", ""), rows)))
        return
    if output is not None:
        refuse_suffix(output, (".svg", ".xml"), "a strategy")
        refuse_output(output, overwrite, strategy_name)
    strategy = find_strategy(strategy_name)
    if output is not None:
        _write(strategy, output, overwrite)
    if as_json:
        written = {} if output is None else {"output": str(output)}
        tree = strategy.root.values()
        emit_json({"name": strategy.name, "description": strategy.description, "tree": tree, **written})
    else:
        click.echo(strategy_text(strategy) if output is None else str(output))


def _write(strategy: Strategy, output: Path, overwrite: bool) -> None:
    """Write a drawing or XML, by the suffix of the file."""
    from pickcli.files.atomic_write import write_text
    from pickcli.strategy.strategy_svg import strategy_svg
    from pickcli.strategy.strategy_xml import strategy_xml

    is_drawing = output.suffix.lower() == ".svg"
    write_text(output, strategy_svg(strategy) if is_drawing else strategy_xml(strategy), overwrite)
