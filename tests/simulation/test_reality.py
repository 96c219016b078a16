"""Levels of reality: read strictly, documented one by one, and kept in what a trial writes."""

from __future__ import annotations

import re
from dataclasses import fields, replace
from pathlib import Path

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from pickcli.errors import InputError
from pickcli.simulation.reality import DEFAULT, IDEAL, Reality, read_reality

DOCS = Path(__file__).parents[2] / "docs" / "reality.md"
HEAD = "format: apc reality\nversion: 1\n"


def written(folder: Path, text: str) -> Path:
    path = folder / "reality.yaml"
    path.write_text(text)
    return path


def test_read_reality_without_a_file_is_the_default() -> None:
    assert read_reality(None) == DEFAULT


def test_read_reality_changes_only_what_the_file_names(tmp_path: Path) -> None:
    path = written(tmp_path, HEAD + "mass_error: 0.25\nlook_time: 3\ncompliant_cup: false\n")
    assert read_reality(path) == replace(DEFAULT, mass_error=0.25, look_time=3.0, compliant_cup=False)


LEVELS = st.fixed_dictionaries(
    {},
    optional={
        "pose_outlier_share": st.floats(0.0, 1.0),
        "pose_outlier_scale": st.floats(1.0, 10.0),
        "pod_position_error": st.floats(0.0, 0.1),
        "mass_error": st.floats(0.0, 1.0),
        "look_time": st.floats(0.0, 60.0),
        **{name: st.booleans() for name in ("pod_shift", "servo", "supervision", "damage_limits")},
    },
)


@given(levels=LEVELS)
def test_read_reality_reads_what_was_written(
    tmp_path_factory: pytest.TempPathFactory, levels: dict[str, object]
) -> None:
    path = written(tmp_path_factory.mktemp("levels"), HEAD + (yaml.safe_dump(levels) if levels else ""))
    assert read_reality(path) == replace(DEFAULT, **levels)  # type: ignore[arg-type]


@pytest.mark.parametrize("reality", [DEFAULT, IDEAL], ids=["default", "ideal"])
def test_read_reality_reads_every_level_of_a_record(tmp_path: Path, reality: Reality) -> None:
    assert read_reality(written(tmp_path, HEAD + yaml.safe_dump(reality.as_dict()))) == reality


@pytest.mark.parametrize(
    ("line", "advice"),
    [
        ("mas_error: 0.1", "did you mean 'mass_error'?"),
        ("mass_error: -0.1", "a share, 0 to 1"),
        ("mass_error: .nan", "finite"),
        ("pod_shift: yes", "write true or false"),
        ("pod_shift: 1", "true or false"),
        ("look_time: 61", "s, 0 to 60"),
        ("pose_outlier_scale: 0.5", "a factor, 1 to 10"),
        ("pod_angle_error: 5 deg", "rad, 0 to 0.05: with more, its walls take the room that picks need"),
        ("pod_angle_error: 0.051", "got 0.051; angles are in rad, not degrees"),
        ("pod_position_error: -0.001", "got -0.001; correct it"),
        ("format: apc reality", "stands twice"),
    ],
)
def test_read_reality_names_place_and_cure(tmp_path: Path, line: str, advice: str) -> None:
    with pytest.raises(InputError) as refused:
        read_reality(written(tmp_path, HEAD + line + "\n"))
    assert advice in str(refused.value)
    assert re.search(r"reality\.yaml:3:\d+: ", str(refused.value))


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("version: 1\n", ":1:1: format"),
        ("format: apc real\nversion: 1\n", ":1:1: format: expected 'apc reality', got \"apc real\";"),
        ("format: apc reality\nversion: 2\n", ":2:1: version: expected 1, the only version there is, got 2;"),
    ],
)
def test_read_reality_refuses_other_files(tmp_path: Path, text: str, place: str) -> None:
    with pytest.raises(InputError) as refused:
        read_reality(written(tmp_path, text))
    assert place in str(refused.value)


@pytest.mark.parametrize("level", [level.name for level in fields(Reality)])
def test_every_level_is_documented_with_its_values(level: str) -> None:
    assert f"        {level}: " in (Reality.__doc__ or "")
    row = next(
        line for line in DOCS.read_text().splitlines() if line.startswith("|") and f"`{level}`" in line
    )
    default = getattr(DEFAULT, level)
    shown = str(default).lower() if isinstance(default, bool) else f"{default:g}"
    assert shown in row.split("|")[2]
