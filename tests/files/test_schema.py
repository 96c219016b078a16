"""What a model refuses is told as "expected, got; what to do", at the place where it stands in the file."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any, Literal

import pytest
from annotated_types import Len
from pydantic import Field, model_validator

from pickcli.errors import InputError
from pickcli.files.schema import Angle, Coordinate, FileModel, Number, Size, Text, validate
from pickcli.files.yaml_reader import parse_yaml


class Corner(FileModel):
    at: Annotated[tuple[Coordinate, ...], Len(2, 2)] = Field(description="a corner [x, y] in m")
    note: Text | None = Field(None, description="a note")


class Move(FileModel):
    source: str = Field(alias="from", description="the name of a place")


class Crate(FileModel):
    kind: Literal["crate"] = Field(description="crate")
    depth: Size = Field(description="m, inside")


class Table(FileModel):
    kind: Literal["table"] = Field(description="table")
    legs: int = Field(description="the number of legs", ge=1, le=8)


class Shop(FileModel):
    """Every form that a field of the files of a cell takes."""

    name: Text = Field(description="a name")
    turn: Angle = Field(0.0, description="rad, about the vertical")
    speed: Annotated[float, Field(gt=0, le=3)] = Field(1.0, description="m/s, of the belt")
    mass: Annotated[float, Field(ge=0, lt=50)] = Field(1.0, description="kg")
    factor: Number = Field(1.0, json_schema_extra={"advice": "state what the maker says"})
    corners: Annotated[tuple[Corner, ...], Len(0, 3)] = Field((), description="corners, against the clock")
    places: dict[str, Annotated[Crate | Table, Field(discriminator="kind")]] = Field(
        {}, description="places by name"
    )
    needed: Number | None = Field(None, description="s at least")

    @model_validator(mode="after")
    def _named(self) -> Shop:
        if self.name == "shop":
            raise ValueError("expected a name of its own, got 'shop'; rename it")
        return self


class Strict(FileModel):
    """Keys that have no default."""

    a: Number = Field(description="N", json_schema_extra={"advice": "measure it"})
    b: Number = Field(description="s at rest")
    c: Number
    d: Number = Field(description="kg")


def told(model: type[FileModel], content: Any) -> list[str]:
    """What is said of a content, without the file; each mistake with its line."""
    source = parse_yaml(json.dumps(content, indent=1), Path("shop.json"))
    try:
        validate(source, model)
    except InputError as error:
        return [line.removeprefix("shop.json:") for line in str(error).splitlines()]
    return []


TABLE = {"kind": "table", "legs": 4}
CASES: dict[str, tuple[dict[str, Any], str, str]] = {
    "too far for metres": (
        {"corners": [{"at": [1, 250]}]}, "7:5: corners[0].at[1]",
        "expected a corner [x, y] in m: less than or equal to 100, got 250"
        "; lengths are in m, not mm",
    ),
    "a negative size": (
        {"places": {"a": {"kind": "crate", "depth": -2.0}}}, "6:4: places.a.depth",
        "expected m, inside: greater than 0, got -2.0; correct it",
    ),
    "a size in mm": (
        {"places": {"a": {"kind": "crate", "depth": 350}}}, "6:4: places.a.depth",
        "expected m, inside: less than or equal to 10, got 350; lengths are in m, not mm",
    ),
    "an angle in degrees": (
        {"turn": 90}, "3:2: turn",
        "expected rad, about the vertical: less than or equal to 6.3, got 90"
        "; angles are in rad, not degrees",
    ),
    "an angle in degrees, the other way": (
        {"turn": -90}, "3:2: turn",
        "expected rad, about the vertical: greater than or equal to -6.3, got -90"
        "; angles are in rad, not degrees",
    ),
    "a speed in mm/s": (
        {"speed": 250}, "3:2: speed",
        "expected m/s, of the belt: less than or equal to 3, got 250; speeds are in m/s, not mm/s",
    ),
    "no speed": (
        {"speed": 0}, "3:2: speed",
        "expected m/s, of the belt: greater than 0, got 0; correct it",
    ),
    "a mass in g": (
        {"mass": 50}, "3:2: mass",
        "expected a value in kg: less than 50, got 50; masses are in kg, not g",
    ),
    "a negative mass": (
        {"mass": -1}, "3:2: mass",
        "expected a value in kg: greater than or equal to 0, got -1; correct it",
    ),
    "too many legs": (
        {"places": {"a": {"kind": "table", "legs": 9}}}, "6:4: places.a.legs",
        "expected the number of legs: less than or equal to 8, got 9; correct it",
    ),
    "half a leg": (
        {"places": {"a": {"kind": "table", "legs": 1.5}}}, "6:4: places.a.legs",
        "expected the number of legs: a valid integer, got 1.5; correct it",
    ),
    "text for a number": (
        {"turn": "fast"}, "3:2: turn",
        'expected rad, about the vertical: a valid number, got "fast"; correct it',
    ),
    "a long text for a number": (
        {"turn": 60 * "x"}, "3:2: turn",
        'expected rad, about the vertical: a valid number, got "xxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxx...'
        "; correct it",
    ),
    "a switch for a number": (
        {"factor": True}, "3:2: factor",
        "expected a valid number, got true; correct it",
    ),
    "a key without a value": (
        {"turn": None}, "3:2: turn",
        "expected rad, about the vertical, got nothing; fill it in",
    ),
    "a key without a value and a meaning": (
        {"factor": None}, "3:2: factor",
        "expected a valid number, got null; correct it",
    ),
    "a number for text": (
        {"name": 7}, "2:2: name",
        "expected a name: text in quotes, got 7; correct it",
    ),
    "no text": (
        {"name": ""}, "2:2: name",
        'expected a name: text of at least 1 character, got ""; correct it',
    ),
    "a text of many characters": (
        {"name": 201 * "x"}, "2:2: name",
        'expected a name: text of at most 200 characters, got "xxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxx...'
        "; correct it",
    ),
    "a control character": (
        {"name": "a\x07"}, "2:2: name",
        'expected a name: text in one line, without control characters, got "a\\u0007"'
        "; correct it",
    ),
    "the name that is taken": (
        {"name": "shop"}, "1:1",
        "expected a name of its own, got 'shop'; rename it",
    ),
    "one number for two": (
        {"corners": [{"at": [1]}]}, "5:4: corners[0].at",
        "expected a corner [x, y] in m: at least 2 entries, got 1; correct it",
    ),
    "two numbers with decimal commas": (
        {"corners": [{"at": [0, 394, -1, 25]}]}, "5:4: corners[0].at",
        "expected numbers with a decimal point, got [0, 394, -1, 25]; a comma begins the next number",
    ),
    "four numbers for two": (
        {"corners": [{"at": [3, 1, 2, 4]}]}, "5:4: corners[0].at",
        "expected a corner [x, y] in m: at most 2 entries, got 4; correct it",
    ),
    "three numbers for two": (
        {"corners": [{"at": [1, 2, 3]}]}, "5:4: corners[0].at",
        "expected a corner [x, y] in m: at most 2 entries, got 3; correct it",
    ),
    "text in a list of numbers": (
        {"corners": [{"at": [1, "x"]}]}, "7:5: corners[0].at[1]",
        'expected a corner [x, y] in m: a valid number, got "x"; correct it',
    ),
    "nothing in a list of numbers": (
        {"corners": [{"at": [1, None]}]}, "7:5: corners[0].at[1]",
        "expected a corner [x, y] in m: a valid number, got null; correct it",
    ),
    "a number for a list": (
        {"corners": 7}, "3:2: corners",
        "expected corners, against the clock: a list [...], got 7; correct it",
    ),
    "a number for an object": (
        {"corners": [7]}, "4:3: corners[0]",
        "expected an object {...}, got 7; correct it",
    ),
    "too many corners": (
        {"corners": 4 * [{"at": [1, 2]}]}, "3:2: corners",
        "expected corners, against the clock: at most 3 entries, got 4; correct it",
    ),
    "a list for an object": (
        {"places": [TABLE]}, "3:2: places",
        'expected places by name: an object {...}, got [{"kind": "table", "legs": 4}]; correct it',
    ),
    "no kind": (
        {"places": {"a": {"legs": 3}}}, "4:3: places.a.kind",
        "expected crate or table, got nothing; add it",
    ),
    "another kind": (
        {"places": {"a": {"kind": "chair", "legs": 3}}}, "5:4: places.a.kind",
        'expected crate or table, got "chair"; correct it',
    ),
    "a key of the other kind": (
        {"places": {"a": {**TABLE, "depth": 0.3}}}, "7:4: places.a.depth",
        "unknown key; known: kind, legs",
    ),
    "a mistyped key": (
        {"trun": 0.1}, "3:2: trun",
        "unknown key; did you mean 'turn'?",
    ),
    "a key that looks like a mark of pydantic's": (
        {"[key]": 0.1}, "3:2: [key]",
        "unknown key; known: corners, factor, mass, name, needed, places, speed, turn",
    ),
    "a key of brackets": (
        {"[[": 0.1}, "3:2: [[",
        "unknown key; known: corners, factor, mass, name, needed, places, speed, turn",
    ),
    "a decimal comma": (
        {"turn": 0, "5": None}, "4:2: 5",
        "unknown key, the rest of a number with a decimal comma; write a point",
    ),
    "a missing inner key": (
        {"places": {"a": {"kind": "crate"}}}, "4:3: places.a.depth",
        "expected m, inside, got nothing; add it",
    ),
}  # fmt: skip


@pytest.mark.parametrize("what", CASES)
def test_a_mistake_is_told_with_what_was_expected_what_is_there_and_what_to_do(what: str) -> None:
    change, where, said = CASES[what]
    assert told(Shop, {"name": "shelf", **change}) == [f"{where}: {said}"]


def test_what_can_be_meant_is_taken() -> None:
    places = {"a": TABLE, "b": {"kind": "crate", "depth": 10}}
    corners = [{"at": [-100, 100.0], "note": None}, {"at": [0, 0], "note": "the first"}, {"at": [1, 1]}]
    assert told(Shop, {"name": 200 * "x", "turn": -6.3, "places": places, "corners": corners}) == []


def test_of_many_keys_that_are_missing_one_line_tells_and_of_few_each() -> None:
    assert told(Strict, {}) == ["1:1: lacks a, b, c and d; add them"]
    assert told(Strict, {"a": 1}) == [
        "1:1: b: expected s at rest, got nothing; add it",
        "1:1: c: expected a value, got nothing; add it",
        "1:1: d: expected a value in kg, got nothing; add it",
    ]
    assert told(Strict, {"b": 1, "c": 2, "d": 3}) == ["1:1: a: expected N, got nothing; measure it"]


@pytest.mark.parametrize("content", [7, [1], "text", True])
def test_what_is_no_object_is_told_as_a_whole(content: Any) -> None:
    expected = f"1:1: expected an object {{...}}, got {json.dumps(content)}; correct it"
    assert told(Strict, content) == [expected]


def test_all_mistakes_are_told_in_the_order_of_the_file() -> None:
    corners = [{"at": [1, 250]}, {"at": [1, "x"]}, {"att": [1, 2]}]
    lines = told(Shop, {"corners": corners, "name": "", "trun": 1})
    assert [line.split(": ")[1] for line in lines] == [
        "corners[0].at[1]", "corners[1].at[1]", "corners[2].at", "corners[2].att", "name", "trun",
    ]  # fmt: skip


@pytest.mark.parametrize(("n", "more"), [(20, 0), (21, 1), (50, 30)])
def test_of_very_many_mistakes_twenty_are_told_and_how_many_more_there_are(n: int, more: int) -> None:
    lines = told(Shop, {"name": "shelf", "places": {f"p{k}": {**TABLE, "legs": 9} for k in range(n)}})
    assert len(lines) == 20 + (more > 0)
    assert more == 0 or lines[-1] == f" and {more} more"


def test_a_field_is_called_as_in_the_file() -> None:
    assert told(Move, {"source": "here"}) == [
        "1:1: from: expected the name of a place, got nothing; add it",
        "2:2: source: unknown key; known: from",
    ]
