"""The page about the architecture names the layers that are enforced; every signature is short."""

from __future__ import annotations

import ast
import re
import tomllib
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGES = sorted(path.parent for path in (ROOT / "pickcli").glob("*/__init__.py"))
FOLDERS = sorted(path.parent for path in (ROOT / "pickcli").rglob("__init__.py"))[1:]  # those in packages too
PAGE = (ROOT / "docs" / "architecture.md").read_text()


def layers() -> list[set[str]]:
    """Packages and modules on each layer of the import rules, the highest first."""
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"]
    lines = next(c["layers"] for c in contracts if c["type"] == "layers")
    return [{name.strip().removeprefix("pickcli.") for name in line.split("|")} for line in lines]


def test_the_table_of_layers_is_the_one_that_is_enforced() -> None:
    table = [row for row in PAGE.splitlines() if row.startswith("| ") and "`" in row]
    told = [set(re.findall(r"`(\w+)`", row)) for row in table]
    assert told == layers()


def docstring(package: Path) -> str:
    return (package / "__init__.py").read_text().split('"""')[1]


def modules(package: Path) -> list[str]:
    """Names of the public modules and folders in a package, sorted."""
    inside = [*package.glob("[a-z]*.py"), *(path.parent for path in package.glob("[a-z]*/__init__.py"))]
    return sorted(path.stem for path in inside)


def test_every_package_is_on_a_layer() -> None:
    assert len(PACKAGES) > 20
    assert {package.name for package in PACKAGES} <= set().union(*layers())


@pytest.mark.parametrize("package", FOLDERS, ids=lambda path: path.name)
def test_a_package_says_what_it_is_and_its_modules_in_reading_order(package: Path) -> None:
    """It names each of its modules and folders once; all else in backticks is another package."""
    assert set(PACKAGES) < set(FOLDERS)
    text = docstring(package)
    own = modules(package)
    told = re.findall(r"`(\w+)`", text)
    assert len(text.strip()) > 40
    assert sorted(name for name in told if name in own) == own
    assert set(told) <= {*own, *(other.name for other in PACKAGES)}


def test_modules_and_folders_of_packages_are_found() -> None:
    assert {"assembly", "pick", "recovery", "stages"} < set(modules(ROOT / "pickcli" / "planning"))
    assert len([name for package in FOLDERS for name in modules(package)]) > 300


MOST_PARAMETERS = 7


def test_no_function_has_many_parameters() -> None:
    """What belongs together is one value. A command has a parameter for each of its options."""
    long, n_functions = [], 0
    for path in sorted((ROOT / "pickcli").rglob("*.py")):
        if "commands" in path.parts:
            continue
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                given = node.args
                names = [arg.arg for arg in (*given.posonlyargs, *given.args, *given.kwonlyargs)]
                n_functions += 1
                if len([name for name in names if name not in ("self", "cls")]) > MOST_PARAMETERS:
                    long.append(f"{path.relative_to(ROOT)}:{node.lineno} {node.name}")
    assert long == []
    assert n_functions > 1500


# Who may ask of which kind a tool is, outside `cell`: in each package the module that chooses by it, and
# those that are of one kind. Whoever adds a kind adds modules here and touches only those that choose.
CHOOSE_THE_KIND = {"grasping/method_choice.py", "simulation/tool_choice.py", "verification/hold_choice.py"}
OF_ONE_KIND = {
    "calibration/tote_location.py",
    "commands/init.py",
    "grasping/cup_envelopes.py",
    "grasping/cup_press.py",
    "grasping/press_check.py",
    "grasping/suction_candidates.py",
    "grasping/suction_grasping.py",
    "grasping/surfaces.py",
    "simulation/bellows.py",
    "simulation/suction.py",
    "verification/finger_kinematics.py",
    "verification/grasp_check.py",
    "verification/load_check.py",
    "verification/pinch_check.py",
    "verification/strayed_pinch_check.py",
    "verification/tipping_check.py",
    "verification/vacuum_events.py",
}
KINDS = {"BareFlange", "CupLimits", "Fingers", "ParallelGripper", "PinchLimits", "Suction", "SuctionCup"}


def asks_of_the_kind(tree: ast.AST) -> list[int]:
    """Lines that ask of which kind a tool is, or count on one: by a class, by what only one kind has."""

    def is_one(node: ast.AST) -> bool:
        if isinstance(node, ast.Attribute):
            of_tool = ast.unparse(node.value).endswith("tool")
            return node.attr == "GRIPPER" or (of_tool and node.attr in ("cup", "gripper", "suction_cup"))
        if not isinstance(node, ast.Call) or ast.unparse(node.func) != "isinstance":
            return False
        return bool(KINDS & {each.id for each in ast.walk(node.args[1]) if isinstance(each, ast.Name)})

    return sorted({node.lineno for node in ast.walk(tree) if is_one(node) and isinstance(node, ast.expr)})


def test_the_kind_of_a_tool_is_asked_where_it_is_chosen_and_nowhere_else() -> None:
    allowed = CHOOSE_THE_KIND | OF_ONE_KIND
    asking = {}
    for path in sorted((ROOT / "pickcli").rglob("*.py")):
        name = str(path.relative_to(ROOT / "pickcli"))
        if not name.startswith("cell/") and (lines := asks_of_the_kind(ast.parse(path.read_text()))):
            asking[name] = lines
    assert {name: lines for name, lines in asking.items() if name not in allowed} == {}
    assert allowed - set(asking) == set()  # a module that asks no more is taken off the list


def test_a_question_for_the_kind_of_a_tool_is_found() -> None:
    told = "if robot.tool.gripper is None:\n    r = tool.cup.radius\nx = isinstance(grip, SuctionCup)\n"
    assert asks_of_the_kind(ast.parse(f"{told}y = gripper.pad\nz = isinstance(x, str)")) == [1, 2, 3]


def forms_contacts(tree: ast.AST) -> bool:
    """Whether a module makes ``AllowedContacts``, by its constructor or by a class method."""
    calls = (ast.unparse(node.func) for node in ast.walk(tree) if isinstance(node, ast.Call))
    return any(call.split(".")[0] == "AllowedContacts" for call in calls)


def test_sets_of_allowed_contacts_are_formed_in_one_module() -> None:
    """Beside their class itself: two modules that form them could allow different things for one motion."""
    forming = {
        str(path.relative_to(ROOT / "pickcli"))
        for path in sorted((ROOT / "pickcli").rglob("*.py"))
        if forms_contacts(ast.parse(path.read_text()))
    }
    assert forming == {"collision/allowed_contacts.py", "collision/stage_contacts.py"}


def imported_by(path: Path, names: set[str]) -> set[str]:
    """Modules that a module imports anywhere, within functions too, but for types alone."""
    tree = ast.parse(path.read_text())
    for_types = [
        id(inner)
        for node in ast.walk(tree)
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"
        for inner in ast.walk(node)
    ]
    imports = [n for n in ast.walk(tree) if isinstance(n, ast.ImportFrom) and id(n) not in for_types]
    found = {name for n in imports for name in (str(n.module), *(f"{n.module}.{a.name}" for a in n.names))}
    return found & names


def test_no_modules_import_each_other_in_a_circle() -> None:
    """Not even by imports within functions: those are for what is heavy, and hide no circle."""
    paths = {
        ".".join(path.relative_to(ROOT).with_suffix("").parts): path
        for path in sorted((ROOT / "pickcli").rglob("*.py"))
        if path.name != "__init__.py"
    }
    assert len(paths) > 400
    graph = {name: imported_by(path, set(paths)) for name, path in paths.items()}
    tuple(TopologicalSorter(graph).static_order())  # raises CycleError, which names the circle


def test_perception_knows_no_options_of_commands() -> None:
    """Scripts and other programs use it, too: what an option is called is for commands to say."""
    option, told = re.compile(r"(?<![\w-])--[a-z]"), []
    for path in sorted((ROOT / "pickcli" / "perception").rglob("*.py")):
        tree = ast.parse(path.read_text())
        documented = (ast.Module, ast.ClassDef, ast.FunctionDef)
        docs = {
            id(node.body[0].value)
            for node in ast.walk(tree)
            if isinstance(node, documented) and isinstance(node.body[0], ast.Expr)
        }
        told += [
            f"{path.name}:{node.lineno}"
            for node in ast.walk(tree)
            if isinstance(node, ast.Constant) and isinstance(node.value, str)
            if id(node) not in docs and option.search(node.value)
        ]
    assert told == []
