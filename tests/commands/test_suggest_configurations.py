"""``apc suggest-configurations``: the table, the JSON, the entry for a cell file."""

from __future__ import annotations

import json
from pathlib import Path

from pickcli.cell.cell_file import load_cell
from pickcli.commands.options.common_options import DEFAULT_CELL
from pickcli.commands.suggest_configurations import command
from pickcli.reachability.ranked_configuration import RankingSettings
from support.command_line import apc

QUICK = ("suggest-configurations", "--bin", "bin_C", "--candidates", 3, "--poses", 5, "--count", 2)


def test_the_entry_is_told_and_written(tmp_path: Path) -> None:
    path = tmp_path / "bin_C.yaml"
    text = apc(*QUICK, "-o", path)
    assert text.code == 0
    assert path.read_text().startswith("  - {name: bin_C, kind: bin, tool_state: straight, q: [")
    assert text.out.endswith(path.read_text())
    assert [line.split()[0] for line in text.out.splitlines()[1:-2]] == ["now", "1", "2"]
    again = apc(*QUICK, "-o", path)
    assert again.code == 3 and "exists already" in again.err
    told = json.loads(apc(*QUICK, "-o", path, "--overwrite", "--json").out)
    assert told["yaml"] == path.read_text() and len(told["suggestions"]) == 2
    assert told["now"]["q"] == load_cell(DEFAULT_CELL).configurations["bin_C"].q.tolist()


def test_the_defaults_are_those_of_the_settings() -> None:
    defaults = {parameter.name: parameter.default for parameter in command.params}
    settings = RankingSettings()
    assert (defaults["candidates"], defaults["poses"]) == (settings.n_kept, settings.n_poses)
    assert defaults["seed"] == settings.seed


def test_an_unknown_bin_is_refused() -> None:
    answer = apc("suggest-configurations", "--bin", "bin_Z")
    assert answer.code == 3 and "unknown place 'bin_Z'" in answer.err
