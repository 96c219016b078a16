"""A named configuration as it stands in a cell file."""

from __future__ import annotations

from pickcli.cell.cell import NamedConfiguration

DECIMALS = 4  # a tenth of a milliradian and of a millimetre: what is rounded so is what must be proven


def configuration_line(named: NamedConfiguration) -> str:
    """One entry of the list ``configurations`` of a cell.yaml, with its newline.

    Args:
        named: The configuration.

    Returns:
        YAML.
    """
    numbers = ", ".join(f"{value + 0.0:.{DECIMALS}f}" for value in named.q.round(DECIMALS).tolist())
    return f"  - {{name: {named.name}, kind: {named.kind}, tool_state: {named.tool_state}, q: [{numbers}]}}\n"
