"""JSON as a text: every problem of its syntax has a place and an advice; nothing but InputError comes out."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.errors import InputError
from pickcli.files.json_reader import parse_json, refuse_bad_syntax
from pickcli.files.yaml_reader import parse_yaml, read_yaml

JSON_VALUES = st.recursive(
    st.none() | st.booleans() | st.integers(-(2**53), 2**53) | st.text(),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(), inner, max_size=4),
    max_leaves=20,
)


@given(JSON_VALUES, st.sampled_from([None, 1, "\t"]), st.booleans())
def test_json_is_read_as_it_was_written(value: object, indent: int | str | None, ascii_only: bool) -> None:
    text = json.dumps(value, indent=indent, ensure_ascii=ascii_only)
    assert parse_json(text, "x") == value
    refuse_bad_syntax(text, "x")


@settings(max_examples=300)
@given(st.binary(max_size=60).map(lambda b: b.decode("utf-8", "replace"))
       | st.text(alphabet='{}[]",:/#ab1-.e\\ \n', max_size=40))  # fmt: skip
def test_any_text_is_json_or_an_input_error(text: str) -> None:
    for read in (parse_json, refuse_bad_syntax):
        try:
            read(text, "x.json")
        except InputError as error:
            assert str(error).startswith("x.json:")
        else:
            json.loads(text)


@pytest.mark.parametrize(
    ("text", "at", "advice"),
    [
        ('{"a": 1, // one\n}', "1:10", "no comments"),
        ('{"a": [\n# one\n1]}', "2:1", "no comments"),
        ("[1, /* one */ 2]", "1:5", "JSON has no comments; delete them"),
        ('{"a": [one]}', "1:8", 'one must stand in double quotes: "one"'),
        ("{'a': 1}", "1:2", "single quotes are not JSON; use double quotes"),
        ('{"a": [{"b": 1,\n{"b": 2}]}', "2:1", "closing '}'"),
        ('{"a": [1', "1:9", "the text ends too early; the file is cut off"),
        ('{"a": "b', "1:7", "the text ends too early; the file is cut off"),
        ("", "1:1", "the file is empty"),
        (" \n", "2:1", "the file is empty"),
        ('{"a": 1 "b": 2}', "1:9", "expected a ',' before"),
        ('{"a": 1,, "b": 2}', "1:9", "a comma with nothing after it; delete the comma"),
        ('{"a": [1,]}', "1:", "delete the comma"),
        ('{"a": 1,}', "1:", "delete the comma"),
        ('{"a": ]', "1:7", "expecting value, got ']'; check commas and brackets before it"),
        ('{"a" 1}', "1:6", "expected a ':' before '1}'"),
        ('{"a": 1, 5: 2}', "1:10", "expecting property name enclosed in double quotes, got '5: 2}'"),
        ('{"a": 0,5}', "1:9", "a comma in a number, or a key without quotes; numbers have a decimal point"),
        ('{"a": +1}', "1:7", "a number begins with a digit or -; leave out the +"),
        ('{"a": -.5}', "1:7", "a number begins with a digit or -; write 0 before the point"),
        (
            '{"a": 1}\n{"a": 1}',
            "2:1",
            "the text continues after its end with '{\"a\": 1}'; one file holds one",
        ),
        ('{"a": [1,\nNone]}', "2:1", "None is Python; JSON writes null"),
        ('{"a": True}', "1:7", "True is Python; JSON writes true"),
        ('{"a": FALSE}', "1:7", "JSON writes false in small letters, got FALSE"),
        ('{"NaN": 1,\n"a": NaN}', "2:6", "NaN is not JSON; write a finite number"),
        ('{"a": NaNs}', "1:7", "NaN is not JSON"),
        ('["Infinity", -Infinity]', "1:14", "-Infinity is not JSON"),
        ("[" + "x" * 5000 + "]", "1:2", "x... must stand in double quotes"),
    ],
)
def test_syntax_errors_name_place_and_advice(text: str, at: str, advice: str) -> None:
    for read in (parse_json, refuse_bad_syntax):
        with pytest.raises(InputError) as caught:
            read(text, "f.json")
        assert str(caught.value).startswith(f"f.json:{at}")
        assert advice in str(caught.value) and len(str(caught.value)) < 300


@pytest.mark.parametrize(
    ("text", "advice"),
    [
        ("[" * 100_000, "nested too deeply"),
        ("[" + "9" * 5000 + "]", "is a whole number of 5000 digits, at most 20 are read; correct it"),
        ("[" + "9" * 21 + "]", "of 21 digits"),
        ('{"a": 1, "b": 2, "a": 3}', "f.json: a: the key stands twice in one object; keep one"),
    ],
)
def test_traps_are_refused(text: str, advice: str) -> None:
    with pytest.raises(InputError) as caught:
        parse_json(text, "f.json")
    assert advice in str(caught.value) and "sys." not in str(caught.value)
    assert parse_json("[" + "9" * 20 + "]", "f.json") == [10**20 - 1]


@pytest.mark.parametrize(
    "text", ["format: apc scene\nversion: 1\n", "---\na: 1\n", "- 1\n- 2\n", "a:\n  b: 2\n"]
)
def test_yaml_in_place_of_json_is_told_once(text: str, tmp_path: Path) -> None:
    path = tmp_path / "scene.txt"
    path.write_text(text)
    with pytest.raises(
        InputError, match=r"scene.txt:1:1: not JSON: it looks like YAML; write it as JSON"
    ) as told:
        read_yaml(path, is_json=True)
    assert "\n" not in str(told.value)


def test_a_text_that_is_nothing_is_told_by_its_beginning() -> None:
    with pytest.raises(
        InputError, match=r"f:1:1: not JSON: it begins with 'hello world'; is it the right file"
    ):
        parse_json("hello world\nagain", "f")


def test_a_file_named_json_is_json_and_one_named_yaml_may_be_either(tmp_path: Path) -> None:
    text = "{a: [1, 2],  # both\n b: 'x'}"
    assert parse_yaml(text, tmp_path / "f.yaml").data == {"a": [1, 2], "b": "x"}
    with pytest.raises(InputError, match=r"f\.json:1:2: not JSON: a must stand in double quotes"):
        parse_yaml(text, tmp_path / "f.json")
    for around in ("\ufeff", "\t", "\n\t"):
        assert parse_yaml(around + '{"a":\t1}\n\t', tmp_path / "f.json").data == {"a": 1}


def test_places_in_json_are_those_of_an_editor(tmp_path: Path) -> None:
    source = parse_yaml('\n{"a": [1,\n\n\t {"b": 2}]}', tmp_path / "f.json")
    assert source.key_positions[("a",)] == (2, 2) and source.value_positions[("a", 0)] == (2, 8)
    assert source.key_positions[("a", 1, "b")] == (4, 4)


@pytest.mark.parametrize("text", ['{"a": %s}', "[%s]", "a: %s"])
def test_a_number_beyond_all_floats_is_told_in_plain_words(text: str, tmp_path: Path) -> None:
    for digits in ("9" * 5000, "1e999", "-1e999"):
        with pytest.raises(InputError, match=r"expected a number, got .* characters\), which is too large"):
            parse_yaml(text % digits, tmp_path / "f.yaml")


@pytest.mark.parametrize(("word", "advice"), [("None", "write null"), ("True", "write true or false")])
def test_what_python_writes_is_told_in_yaml_too(word: str, advice: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=f"f.yaml:2:5: b: expected .*, got {word}; {advice}"):
        parse_yaml(f"a: 1\nb:  {word}", tmp_path / "f.yaml")
    assert parse_yaml(f"a: '{word}'", tmp_path / "f.yaml").data == {"a": word}


def test_a_tab_that_indents_yaml_is_told_as_one(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"f\.yaml:2:1: not YAML: .*; indent with spaces, not tabs"):
        parse_yaml("a:\n\tb: 1\n", tmp_path / "f.yaml")
