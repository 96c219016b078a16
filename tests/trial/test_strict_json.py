"""JSON from outside: every problem has a place and an advice; nothing but InputError comes out."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.errors import InputError
from pickcli.files.file_kind import HDF5_MAGIC, ORDER
from pickcli.trial.strict_json import MAX_BYTES, MAX_DEPTH, Document, parse_json, read_json

JSON_VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.text(),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(), inner, max_size=4),
    max_leaves=20,
)


def leaves(value: object, place: tuple[str | int, ...] = ()) -> list[tuple[str | int, ...]]:
    """Paths of every value inside a value, itself included."""
    parts = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return [place] + [found for key, inner in parts for found in leaves(inner, (*place, key))]


@given(JSON_VALUES, st.sampled_from([None, 1, "\t"]), st.booleans())
def test_every_value_is_found_where_it_stands(
    value: object, indent: int | str | None, ascii_only: bool
) -> None:
    text = json.dumps(value, indent=indent, ensure_ascii=ascii_only)
    document = parse_json(text.encode("utf-8", "surrogatepass") if ascii_only else _encodable(text), "x")
    decoder = json.JSONDecoder()
    for place in leaves(document.value):
        found, _ = decoder.raw_decode(document.text, document.values[place])
        assert found == _at(document, place)


def _encodable(text: str) -> bytes:
    return text.encode("utf-8", "replace")


def _at(document: Document, place: tuple[str | int, ...]) -> object:
    value = document.value
    for key in place:
        value = value[key]
    return value


@settings(max_examples=300)
@given(st.binary(max_size=60) | st.text(alphabet='{}[]",:/#ab1-.e\\ \n', max_size=40).map(str.encode))
def test_any_bytes_parse_or_raise_input_error(data: bytes) -> None:
    try:
        document = parse_json(data, "x.json")
    except InputError as error:
        assert "x.json" in str(error)
    else:
        assert document.value == json.loads(data.decode("utf-8-sig"))


@pytest.mark.parametrize(
    ("text", "at", "advice"),
    [
        ('{"a": 1, // one\n}', "1:10", "no comments"),
        ('{"a": [\n# one\n1]}', "2:1", "no comments"),
        ('{"a": [one]}', "1:8", "double quotes"),
        ("{'a': 1}", "1:2", "single quotes are not JSON; use double quotes"),
        ('{"a": [{"b": 1,\n{"b": 2}]}', "2:1", "closing '}'"),
        ('{"a": [1', "1:9", "too early"),
        ("", "1:1", "too early"),
        ('{"a": 1 "b": 2}', "1:9", "','"),
        ('{"a": 1, "b": 2, "a": 3}', "1:18", "stands twice"),
    ],
)
def test_syntax_errors_name_place_and_advice(text: str, at: str, advice: str) -> None:
    with pytest.raises(InputError) as caught:
        parse_json(text.encode(), "f.json")
    assert str(caught.value).startswith(f"f.json:{at}:")
    assert advice in str(caught.value)


@pytest.mark.parametrize("text", ['{"a": [1,]}', '{"a": 1,}'])
def test_trailing_commas_are_named(text: str) -> None:
    with pytest.raises(InputError, match="delete the comma"):
        parse_json(text.encode(), "f.json")


@pytest.mark.parametrize(
    ("data", "advice"),
    [
        (b"[" * 100_000, "nested deeper"),
        (b"[" * 40 + b"]" * 40, "nested deeper"),
        (b'{"a": NaN}', "NaN is not JSON"),
        (b"[" + b"9" * 5000 + b"]", "remove it"),
        (b'{"a": "\xff"}', "not UTF-8"),
        (b" " * (MAX_BYTES + 1), "larger than"),
    ],
)
def test_hostile_texts_are_refused(data: bytes, advice: str) -> None:
    with pytest.raises(InputError, match=advice):
        parse_json(data, "f.json")


def test_texts_may_be_nested_as_deep_as_stated_and_no_deeper() -> None:
    assert parse_json(b"[" * MAX_DEPTH + b"]" * MAX_DEPTH, "f.json").value
    with pytest.raises(InputError, match="nested deeper than 32"):
        parse_json(b"[" * (MAX_DEPTH + 1) + b"]" * (MAX_DEPTH + 1), "f.json")


def test_what_is_no_regular_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        read_json(tmp_path / "missing.json")
    with pytest.raises(InputError, match="not a regular file"):
        read_json(tmp_path)
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(InputError, match="not a regular file"):
        read_json(tmp_path / "pipe")


def test_a_byte_order_mark_is_no_error(tmp_path: Path) -> None:
    path = tmp_path / "bom.json"
    path.write_bytes(b'\xef\xbb\xbf{"a": 1}')
    assert read_json(path).value == {"a": 1}


@pytest.mark.parametrize(
    ("text", "advice"),
    [
        ('{"a": 1,, "b": 2}', "a comma with nothing after it; delete the comma"),
        ('{"a": ]', "expecting value, got ']'; check commas and brackets before it"),
        ("[1 2]", "expected a ',' before '2]'"),
        ('{"a" 1}', "expected a ':' before '1}'"),
        ("{[1]: 2}", "expecting property name enclosed in double quotes, got '[1]: 2}'"),
        ('{"a": 1, 5: 2}', "expecting property name enclosed in double quotes, got '5: 2}'"),
        ('{"a": 1 "b"}', "expected a ',' before"),
        ("[1, # one\n2]", "JSON has no comments; delete them"),
        ("[1, /* one */ 2]", "JSON has no comments; delete them"),
    ],
)
def test_the_advice_fits_the_mistake(text: str, advice: str) -> None:
    with pytest.raises(InputError) as caught:
        parse_json(text.encode(), "f.json")
    assert advice in str(caught.value)


def test_a_megabyte_is_read_and_no_byte_more(tmp_path: Path) -> None:
    path = tmp_path / "large.json"
    path.write_bytes(b" " * 999_998 + b"{}")
    assert read_json(path).value == {}
    path.write_bytes(b" " * 999_999 + b"{}")
    with pytest.raises(InputError, match="at most 1000000 bytes are read"):
        read_json(path)
    assert parse_json(b" " * 999_998 + b"{}", "f.json").value == {}
    with pytest.raises(InputError, match="larger than 1000000 bytes"):
        parse_json(b" " * 999_999 + b"{}", "f.json")


def test_lines_and_columns_are_those_of_an_editor() -> None:
    document = parse_json(b'\n{"a": [1,\n\n  {"b": 2}]}', "f")
    assert (document.at(), document.at_key("a")) == ("f:2:1", "f:2:2")
    assert (document.at("a"), document.at("a", 0)) == ("f:2:7", "f:2:8")
    assert (document.at_key("a", 1, "b"), document.at("a", 1, "b")) == ("f:4:4", "f:4:9")


def test_what_does_not_stand_in_a_text_is_told_at_its_beginning() -> None:
    document = parse_json(b'{"a": 1}', "f")
    assert document.at("b") == document.at_key("b") == "f:1:1"


def test_a_file_of_another_kind_is_told_as_such(tmp_path: Path) -> None:
    path = tmp_path / "f.json"
    path.write_bytes(HDF5_MAGIC + bytes(100))
    with pytest.raises(InputError, match="is a roadmap or trajectory database, but an order is wanted"):
        read_json(path, ORDER)
