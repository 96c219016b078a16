"""Every command explains itself: help with an example, a section in the docs, and all of it at once."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import click
import pytest

from pickcli.commands import main as cli
from support.command_line import apc

DOCS = Path(__file__).parents[2] / "docs" / "commands.md"
HEAVY = {
    *("numpy", "pybullet", "ompl", "toppra", "ruckig", "fcl", "h5py", "pydantic", "yaml", "rich", "scipy"),
    *("dask", "distributed", "matplotlib", "cv2"),
}
EVERYWHERE = {"--verbose", "--debug"}  # described once for all commands
CELL = {"--cell", "--items", "--arm", "--standing"}  # described once for all commands that have them
RANDOM = {
    "init",
    "build-roadmap",
    "build-trajectories",
    "compare-planners",
    "make-order",
    "make-pallet-order",
    "make-scene",
    "make-stream",
    "locate-pod",
    "locate-tote",
    "perceive",
    "plan-drive",
    "watch-zone",
    "detect-pallet",
    "plan-pallet",
    "plan-pick",
    "plan-shift",
    "plan-stow",
    "plan-topple",
    "plan-move",
    "render",
    "execute",
    "roll-out",
    "run-trial",
    "show-envelope",
    "show-grasps",
    "suggest-configurations",
    "suggest-mount",
    "try-grasp",
}


def command(name: str) -> click.Command:
    found = cli.apc.get_command(click.Context(cli.apc), name)
    assert found is not None
    return found


def options(name: str) -> set[str]:
    return {
        option
        for parameter in command(name).params
        for option in (*parameter.opts, *parameter.secondary_opts)
    }


@pytest.mark.parametrize("name", cli.COMMANDS)
def test_help_has_the_line_of_the_list_and_an_example(name: str) -> None:
    answer = apc(name, "--help")
    assert answer.code == 0 and answer.err == ""
    help_text = command(name).help
    assert help_text is not None
    assert help_text.splitlines()[0] == cli.COMMANDS[name]
    assert re.search(rf"Example:\n +apc {name} \S", answer.out)


@pytest.mark.parametrize("name", cli.COMMANDS)
def test_examples_use_options_that_exist(name: str) -> None:
    examples = re.findall(rf"^ +apc {name} (.*)$", apc(name, "--help").out, re.MULTILINE)
    assert examples
    for example in examples:
        used = {word for word in example.split() if re.match(r"--?[a-z]", word)}
        assert used <= options(name)


OUTPUTS = {"--output", "--video", "--picture"}


@pytest.mark.parametrize("name", cli.COMMANDS)
def test_shared_options_are_there(name: str) -> None:
    assert "--json" in options(name)
    assert ("--seed" in options(name)) == (name in RANDOM)
    assert ("--overwrite" in options(name)) == bool(OUTPUTS & options(name))


@pytest.mark.parametrize("name", cli.COMMANDS)
def test_the_docs_have_a_section_with_every_option(name: str) -> None:
    sections = re.split(r"^## ", DOCS.read_text(), flags=re.MULTILINE)
    section = next(section for section in sections if section.startswith(f"apc {name}\n"))
    assert re.search(rf"^apc {name} ", section, re.MULTILINE)
    former = {option for each in command(name).params if vars(each).get("hidden") for option in each.opts}
    own = options(name) - former - {"--json", "--seed", "--overwrite", "--output", "-o"} - CELL - EVERYWHERE
    assert {option for option in own if option.startswith("--") and option not in section} == set()


def test_the_docs_name_every_exit_code() -> None:
    text = DOCS.read_text()
    assert {code for code in (0, 1, 2, 3, 4, 5, 6, 130) if f"| {code} |" not in text} == set()


def test_the_list_of_commands_is_in_the_help() -> None:
    answer = apc("--help")
    assert answer.code == 0
    assert {name for name in cli.COMMANDS if name not in answer.out} == set()


@pytest.mark.parametrize("argv", [["--help"], ["--version"]])
def test_nothing_heavy_is_imported_for_it(argv: list[str]) -> None:
    program = (
        f"import sys; sys.argv = {['apc', *argv]}\n"
        "from pickcli.commands import main\n"
        "try: main.main()\n"
        "finally: print(*{name.split('.')[0] for name in sys.modules}, file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert set(done.stderr.split()) & HEAVY == set()


def test_nothing_heavy_is_imported_for_the_help_of_any_command() -> None:
    program = (
        "import sys, importlib\n"
        f"for name in {list(cli.COMMANDS)}: "
        "importlib.import_module('pickcli.commands.' + name.replace('-', '_'))\n"
        "print(*{name.split('.')[0] for name in sys.modules})"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert set(done.stdout.split()) & HEAVY == set()
