"""The verifier takes data from cell, scene and motion, and of their functions only these."""

from __future__ import annotations

import ast
from pathlib import Path

ROOT = Path(__file__).parents[2]
SHARED = {
    "pickcli.cell.robot": {"massless_link"},  # a link that only carries a frame
    "pickcli.cell.shapes": {"hull"},  # the polyhedron of some corners
    "pickcli.motion.plan": {"other_arm_elsewhere"},  # compares stated arms
    "pickcli.motion.plan_file": {"motion_hash"},
    "pickcli.scene.scene_file": {"scene_hash"},
}
PACKAGES = ("pickcli.cell", "pickcli.scene", "pickcli.motion")


def functions(module: str) -> set[str]:
    """Names of the functions that a module defines."""
    tree = ast.parse((ROOT / (module.replace(".", "/") + ".py")).read_text())
    return {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}


def test_the_second_opinion_imports_only_these_functions() -> None:
    found: dict[str, set[str]] = {}
    for path in sorted((ROOT / "pickcli" / "verification").glob("*.py")):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Import):
                assert not any(alias.name.startswith("pickcli") for alias in node.names), path
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith(PACKAGES):
                assert node.module is not None
                taken = {alias.name for alias in node.names} & functions(node.module)
                if taken:
                    found.setdefault(node.module, set()).update(taken)
    assert found == SHARED


def test_the_page_names_them_all() -> None:
    page = (ROOT / "docs" / "verification.md").read_text().split("| | planner | verifier |")[0]
    for names in SHARED.values():
        assert all(f"`{name}`" in page for name in names)
