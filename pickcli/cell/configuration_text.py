"""Formatting of named configurations for a cell file."""

from __future__ import annotations

from pickcli.cell.cell import NamedConfiguration

DECIMALS = 4  # 0.1 mrad or 0.1 mm; motions must be proven for the rounded values


def configuration_line(named: NamedConfiguration) -> str:
    """Format one entry of the list ``configurations`` of a cell.yaml, with its newline.

    Args:
        named: The configuration.

    Returns:
        YAML.
    """
    numbers = ", ".join(f"{value + 0.0:.{DECIMALS}f}" for value in named.q.round(DECIMALS).tolist())
    return f"  - {{name: {named.name}, kind: {named.kind}, tool_state: {named.tool_state}, q: [{numbers}]}}\n"
