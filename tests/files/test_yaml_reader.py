"""The YAML reader: what it accepts means what it looks like, and nothing it is fed can hurt."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pickcli.errors import InputError
from pickcli.files.source import Source
from pickcli.files.yaml_reader import MAX_BYTES, parse_yaml, quoted, read_yaml

Refused = Callable[[Callable[[], object]], str]

texts = st.text(st.characters(codec="utf-8", exclude_categories=["Cc", "Cs", "Zl", "Zp"]), max_size=8)
plain = st.recursive(
    st.one_of(
        st.none(),
        st.booleans(),
        st.integers(-(2**53), 2**53),
        st.floats(allow_nan=False, allow_infinity=False),
        texts,
    ),
    lambda inner: st.one_of(st.lists(inner, max_size=4), st.dictionaries(texts, inner, max_size=4)),
    max_leaves=12,
)


def read(folder: Path, text: str | bytes) -> Source:
    path = folder / "file.yaml"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_yaml(path)


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("yaml")


@given(value=plain)
def test_json_means_the_same_here(folder: Path, value: object) -> None:
    data = read(folder, json.dumps(value, ensure_ascii=False)).data
    assert data == value
    assert type(data) is type(value) or isinstance(value, float | int)


@given(content=st.one_of(st.binary(max_size=60), st.text(max_size=60)))
def test_whatever_is_in_the_file_it_is_read_or_refused(folder: Path, content: str | bytes) -> None:
    try:
        read(folder, content if isinstance(content, bytes) else content.encode("utf-8", "surrogatepass"))
    except InputError as error:
        assert "file.yaml" in str(error)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1e-3", 0.001),
        ("-.5", -0.5),
        ("+3", 3),
        ("0", 0),
        ("1.", 1.0),
        ("true", True),
        ("~", None),
        ("", None),
        ("plain words", "plain words"),
        ('"no"', "no"),
        ("'12:30'", "12:30"),
        ("NaN", "NaN"),
        ("y", "y"),
    ],
)
def test_plain_scalars_follow_yaml_1_2(folder: Path, text: str, value: object) -> None:
    data = read(folder, f"key: {text}\n").data["key"]
    assert data == value
    assert type(data) is type(value)


@pytest.mark.parametrize(
    ("text", "advice"),
    [
        ("no", "true or false"),
        ("On", "true or false"),
        ("12:30", "quote"),
        ("010", "leading zeros"),
        ("007.5", "leading zeros"),
        ("1_000", "underscores"),
        ("0x1F", "decimal"),
        (".inf", "finite"),
        ("2016-07-01", "quote"),
    ],
)
def test_what_yaml_1_1_reads_otherwise_is_an_error_with_advice(
    folder: Path, refused: Refused, text: str, advice: str
) -> None:
    message = refused(lambda: read(folder, f"a:\n  b: [1, {text}]\n"))
    assert "file.yaml:2:10: a.b[1]: expected" in message
    assert text in message
    assert advice in message


BOMB = "a: &a [x, x]\nb: &b [*a, *a]\nc: [*b, *b]\n"


@pytest.mark.parametrize(
    ("text", "place", "what"),
    [
        (BOMB, "1:4", "anchors and aliases"),
        ("a: 1\nb: *a\n", "2:4", "alias"),
        ("a: !!python/object:os.system x\n", "1:4", "tag"),
        ("a: 1\na: 2\n", "2:1", "stands twice"),
        ("a: 1\n---\nb: 2\n", "2:1", "second document"),
        ("[" * 40 + "]" * 40, "1:34", "nested deeper"),
        ("[" * 100_000, "1:34", "nested deeper"),
        ("? [a]\n: b\n", "1:3", "expected a name as key"),
        ("a: [1, 2\n", "2:1", "not YAML"),
        ("a:\n\t- b\n", "2:1", "not YAML"),
        ("", "1:1", "empty"),
    ],
)
def test_what_is_dangerous_or_ambiguous_is_refused_with_its_place(
    folder: Path, refused: Refused, text: str, place: str, what: str
) -> None:
    message = refused(lambda: read(folder, text))
    assert f"file.yaml:{place}:" in message
    assert what in message


def test_all_mistakes_are_told_at_once_in_the_files_order(folder: Path, refused: Refused) -> None:
    lines = refused(lambda: read(folder, "a: no\nb: 1\nc: 0x10\nb: 2\n")).splitlines()
    assert [line.split(":")[1] for line in lines] == ["1", "3", "4"]


def test_unreadable_files_are_named(tmp_path: Path, refused: Refused) -> None:
    big = tmp_path / "big.yaml"
    big.write_bytes(b"a" * (MAX_BYTES + 1))
    binary = tmp_path / "binary.yaml"
    binary.write_bytes(b"a: \xff\n")
    assert "no such file" in refused(lambda: read_yaml(tmp_path / "none.yaml"))
    assert "not a regular file" in refused(lambda: read_yaml(tmp_path))
    assert "at most" in refused(lambda: read_yaml(big))
    assert "byte 3 is not UTF-8" in refused(lambda: read_yaml(binary))


@given(value=plain)
def test_json_in_ascii_means_the_same_here(folder: Path, value: object) -> None:
    """With what lies beyond 16 bits as two escapes."""
    assert read(folder, json.dumps(value)).data == value


@pytest.mark.parametrize("text", ["\U0001f4e6", "\U00010000", "\U0010ffff", "a\U0001d11e\\b", "\\\U0001f600"])
def test_two_escapes_of_json_are_one_character(folder: Path, text: str) -> None:
    assert read(folder, json.dumps([text])).data == [text]


def test_escapes_after_a_backslash_are_no_character(folder: Path) -> None:
    text = r"\ud83d\udce6"
    assert read(folder, json.dumps([text])).data == [text]


def test_a_megabyte_is_read_and_no_byte_more(folder: Path, refused: Refused) -> None:
    assert len(read(folder, "a" * 1_000_000).data) == 1_000_000
    assert "at most 4000000 bytes are read" in refused(lambda: read(folder, "a" * 4_000_001))


def test_thirty_two_levels_are_read_and_no_more(folder: Path, refused: Refused) -> None:
    assert read(folder, "[" * 33 + "]" * 33).data
    assert "nested deeper than 32 levels" in refused(lambda: read(folder, "[" * 34 + "]" * 34))


@pytest.mark.parametrize("sign", ["", "-"])
def test_integers_are_exact_up_to_nineteen_digits(folder: Path, sign: str) -> None:
    for n, kind in ((18 - len(sign), int), (19 - len(sign), int), (20 - len(sign), float), (300, float)):
        data = read(folder, sign + "9" * n).data
        assert type(data) is kind and data == kind(sign + "9" * n)


@pytest.mark.parametrize("n", [1, 20, 21, 22, 60])
def test_twenty_mistakes_are_told_and_the_others_counted(folder: Path, refused: Refused, n: int) -> None:
    lines = refused(lambda: read(folder, "".join(f"k{i}: no\n" for i in range(n)))).splitlines()
    assert len(lines) == min(n, 20) + (n > 20)
    assert n <= 20 or lines[-1].endswith(f"file.yaml: and {n - 20} more")


def test_a_mistake_stands_at_its_key_or_at_the_nearest_parent(folder: Path) -> None:
    source = read(folder, "a:\n  b:\n    - 1\n    - [2, 3]\n")
    for key, place in (
        (("a", "b"), (2, 3)), (("a", "b", 1), (4, 7)), (("a", "b", 1, 1), (4, 11)),
        (("a", "b", 1, 7), (4, 7)), (("a", "c"), (1, 1)), (("a", "c", "d"), (1, 1)), ((), (1, 1)),
    ):  # fmt: skip
        source.add(key, "wrong")
        assert (source.problems[-1].line, source.problems[-1].column) == place
    assert source.problems[1].text == "a.b[1]: wrong" and source.problems[-1].text == "wrong"


def test_the_same_mistake_is_told_once(folder: Path, refused: Refused) -> None:
    source = read(folder, "a: 1\nb: 2\n")
    for key in ("b", "a", "b"):
        source.add((key,), "wrong")
    lines = refused(source.check).splitlines()
    assert [line.split("file.yaml:")[1] for line in lines] == ["1:1: a: wrong", "2:1: b: wrong"]


def test_a_source_without_marks_points_to_the_beginning(tmp_path: Path, refused: Refused) -> None:
    source = Source(tmp_path / "x")
    source.add(("a", 0), "wrong")
    assert refused(source.check) == f"{tmp_path / 'x'}:1:1: a[0]: wrong"


def test_a_file_that_is_cut_off_is_called_by_its_kind(tmp_path: Path, refused: Refused) -> None:
    for name, kind in (("a.json", "JSON"), ("a.yaml", "YAML")):
        (tmp_path / name).write_text('{"a": [1,\n 2\n')
        assert f"{name}:3:1: not {kind}: " in refused(partial(read_yaml, tmp_path / name))


@pytest.mark.parametrize("text", ["'a': !!str 1\n", "a: !x 1\n"])
def test_tags_are_refused(folder: Path, refused: Refused, text: str) -> None:
    assert "is not allowed; leave it out" in refused(lambda: read(folder, text))


def test_degrees_are_not_only_left_out(folder: Path, refused: Refused) -> None:
    assert "tag !degrees is not allowed; write the angle in rad" in refused(
        lambda: read(folder, "a: !degrees 45\n")
    )


def test_a_conflict_of_git_is_named(folder: Path, refused: Refused) -> None:
    text = "a: 1\n<<<<<<< HEAD\nb: 2\n=======\nb: 3\n>>>>>>> other\n"
    assert "not YAML: could not find expected ':'; a conflict of git begins in line 2; resolve it" in refused(
        lambda: read(folder, text)
    )


@pytest.mark.parametrize("line_break", ["\n", "\r", "\r\n", "\x85", "\u2028"])
def test_a_tab_is_named_on_its_line_whatever_ends_the_lines(line_break: str, tmp_path: Path) -> None:
    text = line_break.join(["a: 1", "b:", "\tc: 2"])
    with pytest.raises(InputError, match=r"f\.yaml:3:1: not YAML: .*; indent with spaces, not tabs"):
        parse_yaml(text, tmp_path / "f.yaml")


@pytest.mark.parametrize("character", ["\0", "\x01", "\x1b", "\x7f"])
def test_a_control_character_is_named_with_its_place(character: str, tmp_path: Path) -> None:
    told = rf"f\.yaml:2:7: the control character U\+{ord(character):04X} is not allowed; delete it"
    with pytest.raises(InputError, match=told):
        parse_yaml(f'ä: "ü€"\nb: "c{character}d"\n'.replace("b: ", "bö: "), tmp_path / "f.yaml")


@pytest.mark.parametrize(
    ("name", "is_plain"),
    [("arm", True), ("arm_1", True), ("a", True), ("no", False), ("None", False), ("null", False),
     ("true", False), ("1e3", False), ("7", False), ("_x", False), ("a-b", False), ("a: b", False)],
)  # fmt: skip
def test_a_name_is_quoted_where_it_is_no_plain_word_or_means_something_else(
    name: str, is_plain: bool
) -> None:
    assert (quoted(name) == name) is is_plain
    assert quoted(name).strip("'\"") == name


@given(st.text(st.characters(exclude_categories=("Cc", "Cs", "Zl", "Zp")), min_size=1, max_size=30))
def test_a_quoted_name_is_read_as_what_it_was(name: str) -> None:
    assert parse_yaml(f"{quoted(name)}: {quoted(name)}\n", Path("x.yaml")).data == {name: name}
