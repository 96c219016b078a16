"""Formats by name: those of the package, and what other packages add."""

from __future__ import annotations

from importlib.metadata import EntryPoint
from pathlib import Path

import pytest

from pickcli import plugins
from pickcli.errors import InputError, UnknownNameError
from pickcli.export.exporter import Exporter
from pickcli.export.formats import BUILT_IN, GROUP, exporter, format_names
from support.added_package import write_package
from support.exported_motions import ur_request

MODULE = """
from pickcli.export.exporter import Exporter
LINES = Exporter("a line for the plan", ".txt", lambda request: request.plan.query.encode())
NOTHING = 3
def fail(request): raise ValueError("nope")
FAILS, TEXT = Exporter("none", ".txt", fail), Exporter("text", ".txt", lambda request: "no bytes")
"""


@pytest.fixture
def added(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """An installed package that adds a format, two that do not work, and one of a name that is taken."""
    name = "added_formats_of_a_test"
    lines, nothing = f"{name}:LINES", f"{name}:NOTHING"
    points = {"fails": f"{name}:FAILS", "text": f"{name}:TEXT"}
    points |= {"lines": lines, "nothing": nothing, "broken": "no_such_module_at_all:X", "csv": lines}
    write_package(tmp_path, name, MODULE, {GROUP: points})
    monkeypatch.syspath_prepend(tmp_path)


@pytest.mark.parametrize("name", BUILT_IN)
def test_formats_of_the_package_are_exporters(name: str) -> None:
    found = exporter(name)
    assert isinstance(found, Exporter) and found.suffix.startswith(".") and found.description


@pytest.mark.usefixtures("added")
def test_what_packages_add_is_listed_and_used() -> None:
    assert format_names() == [*BUILT_IN, "broken", "fails", "lines", "nothing", "text"]
    assert exporter("lines").encode(ur_request()) == b"move there and back"


@pytest.mark.usefixtures("added")
@pytest.mark.parametrize(("name", "told"), [("fails", "ValueError: nope"), ("text", "its content is str")])
def test_what_fails_in_the_code_of_a_package_is_named(name: str, told: str) -> None:
    with pytest.raises(InputError, match=f"format '{name}': {told}.*correct"):
        exporter(name).encode(ur_request())


@pytest.mark.usefixtures("added")
def test_formats_of_the_package_are_not_replaced() -> None:
    assert exporter("csv").suffix == ".csv"


@pytest.mark.usefixtures("added")
@pytest.mark.parametrize(
    ("name", "told"), [("broken", "cannot be loaded"), ("nothing", "is no pickcli.export")]
)
def test_what_cannot_be_used_is_named(name: str, told: str) -> None:
    with pytest.raises(InputError, match=f"format '{name}': .*{told}"):
        exporter(name)


def test_an_unknown_format_comes_with_what_was_meant() -> None:
    with pytest.raises(UnknownNameError, match="unknown format 'joint_trajectory'; did you mean 'joint-traj"):
        exporter("joint_trajectory")


def test_of_two_packages_with_one_name_the_first_by_its_value_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    points = [EntryPoint("x", value, GROUP) for value in ("b:X", "a:X")]
    monkeypatch.setattr(plugins, "entry_points", lambda group: points)
    assert plugins.added(GROUP, ())["x"].value == "a:X" and plugins.added(GROUP, ("x",)) == {}
