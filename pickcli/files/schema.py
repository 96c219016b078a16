"""From plain values to a checked model: pydantic's errors, told with file, line, column and advice."""

from __future__ import annotations

import difflib
import json
import re
from typing import Annotated, Any, TypeVar, get_args

from annotated_types import Len
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from pickcli.files.yaml_reader import MOST_TOLD, Key, Source

Model = TypeVar("Model", bound="FileModel")

Number = Annotated[float, Field(allow_inf_nan=False)]

# What a figure may be at most. The bounds are far from any cell that is built; what is beyond them was
# written in another unit.
Coordinate = Annotated[float, Field(ge=-100, le=100)]  # m
Angle = Annotated[float, Field(ge=-6.3, le=6.3)]  # rad
Size = Annotated[float, Field(gt=0, le=10)]  # m, of what stands in a cell
Thickness = Annotated[float, Field(gt=0, le=0.5)]  # m, of boards, posts, cups
Seconds = Annotated[float, Field(ge=0, le=30)]
Force = Annotated[float, Field(gt=0, le=1e6)]  # N, or Nm
Vector = Annotated[tuple[Coordinate, ...], Len(3, 3)]
Angles = Annotated[tuple[Angle, ...], Len(3, 3)]
Text = Annotated[str, Field(min_length=1, max_length=200, pattern=r"^[^\x00-\x1f\x7f-\x9f]*$")]  # for people


class FileModel(BaseModel):
    """Base of everything read from files: strict types, unknown keys refused, immutable."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True, allow_inf_nan=False)


def validate(source: Source, model: type[Model]) -> Model:
    """The file's content as ``model``. Raises InputError with all mistakes, each with its place."""
    try:
        # By way of JSON: there a list may become a tuple while everything else stays strict.
        return model.model_validate_json(json.dumps(source.data))
    except ValidationError as error:
        details = error.errors(include_url=False)
        for detail in details[:MOST_TOLD]:
            note(source, model, detail)
        source.n_untold += len(details[MOST_TOLD:])
        source.check()
        raise


def note(source: Source, model: type[BaseModel], detail: Any) -> None:
    """Add one of pydantic's errors to the source's problems."""
    key: Key = tuple(part for part in detail["loc"] if part != "[key]")
    source.add(key, explain(model, key, detail))


def explain(model: type[BaseModel], key: Key, detail: Any) -> str:
    """One of pydantic's errors as "expected, got; what to do"."""
    kind, given = detail["type"], detail["input"]
    if kind == "missing":
        return f"expected {_meaning(model, key)}, got nothing; add it"
    if kind == "extra_forbidden":
        known = sorted(_fields(model, key[:-1]))
        close = difflib.get_close_matches(str(key[-1]), known, n=1)
        hint = f"did you mean {close[0]!r}?" if close else f"known: {', '.join(known)}"
        return f"unknown key; {hint}"
    if kind == "value_error":
        return str(detail["ctx"]["error"])
    expected = detail["msg"].removeprefix("Input should ").removeprefix("be ").removeprefix("have ")
    meaning = _meaning(model, key)
    advice = _unit(meaning) if _is_far_off(detail) else "correct it"
    told = meaning if meaning.startswith(expected) else f"{meaning}: {expected}"
    return f"expected {told}, got {_short(given)}; {advice}"


def _is_far_off(detail: Any) -> bool:
    """Whether a figure is too large in its amount: a negative one where none may be is no matter of units."""
    if detail["type"] == "greater_than_equal":
        return float(detail["ctx"]["ge"]) < 0.0
    return str(detail["type"]) == "less_than_equal"


def _unit(meaning: str) -> str:
    """What to do about a figure that is far too large: it was meant in another unit."""
    found = re.search(r"(?<!/)\b(m/s|m|rad|s|kg)\b(?!/| ?\()", meaning)
    return "correct it" if found is None else _UNITS[found.group()]


_UNITS = {
    "m/s": "speeds are in m/s, not mm/s",
    "m": "lengths are in m, not mm",
    "rad": "angles are in rad, not degrees",
    "s": "times are in s, not ms",
    "kg": "masses are in kg, not g",
}


def _short(value: Any) -> str:
    text = json.dumps(value)
    return text if len(text) <= 40 else text[:37] + "..."


def _meaning(model: type[BaseModel], key: Key) -> str:
    """The field's own description, if it has one; for a value in a list or mapping that of the whole."""
    while key and isinstance(key[-1], int):
        key = key[:-1]
    siblings = _fields(model, key[:-1])
    if not siblings and len(key) > 1:
        return _meaning(model, key[:-1])
    field = siblings.get(str(key[-1])) if key else None
    return field.description if field is not None and field.description else "a value"


def _fields(model: type[BaseModel], key: Key) -> dict[str, Any]:
    """The fields of the model that stands at ``key`` inside ``model``; empty where it is no model."""
    annotation: Any = model
    for part in key:
        fields = getattr(annotation, "model_fields", None)
        if fields is None:
            annotation = _innermost(annotation)
        elif part in fields:
            annotation = _unwrapped(fields[part].annotation)
        else:
            return {}
    return dict(getattr(annotation, "model_fields", {}))


def _innermost(annotation: Any) -> Any:
    """The value type of a tuple, list or dict annotation."""
    arguments = [a for a in get_args(annotation) if a is not Ellipsis]
    return _unwrapped(arguments[-1]) if arguments else annotation


def _unwrapped(annotation: Any) -> Any:
    """The annotation without an optional None."""
    arguments = get_args(annotation)
    return next(a for a in arguments if a is not type(None)) if type(None) in arguments else annotation
