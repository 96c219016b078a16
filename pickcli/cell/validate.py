"""From plain values to a checked model: pydantic's errors, told with file, line, column and advice."""

from __future__ import annotations

import difflib
import json
from typing import Annotated, Any, TypeVar, get_args

from annotated_types import Len
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from pickcli.cell.yaml_reader import Key, Source

Model = TypeVar("Model", bound="FileModel")

Number = Annotated[float, Field(allow_inf_nan=False)]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]
Vector = Annotated[tuple[Number, ...], Len(3, 3)]


class FileModel(BaseModel):
    """Base of everything read from files: strict types, unknown keys refused, immutable."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True, allow_inf_nan=False)


def validate(source: Source, model: type[Model]) -> Model:
    """The file's content as ``model``. Raises InputError with all mistakes, each with its place."""
    try:
        # By way of JSON: there a list may become a tuple while everything else stays strict.
        return model.model_validate_json(json.dumps(source.data))
    except ValidationError as error:
        for detail in error.errors(include_url=False):
            note(source, model, detail)
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
    return f"expected {_meaning(model, key)}: {expected}, got {_short(given)}; correct it"


def _short(value: Any) -> str:
    text = json.dumps(value)
    return text if len(text) <= 40 else text[:37] + "..."


def _meaning(model: type[BaseModel], key: Key) -> str:
    """The field's own description, if it has one."""
    field = _fields(model, key[:-1]).get(str(key[-1])) if key else None
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
    """The annotation without Annotated[...] and without an optional None."""
    arguments = get_args(annotation)
    if hasattr(annotation, "__metadata__"):
        return _unwrapped(arguments[0])
    if type(None) in arguments:
        return _unwrapped(next(a for a in arguments if a is not type(None)))
    return annotation
