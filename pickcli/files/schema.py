"""Validates plain values with pydantic models, and reports errors with file, line, column and advice."""

from __future__ import annotations

import json
import math
import re
from types import UnionType
from typing import Annotated, Any, TypeVar, Union, get_args, get_origin

from annotated_types import Len
from pydantic import BaseModel, ConfigDict, Field, Tag, ValidationError

from pickcli.files.source import MAX_REPORTED, Key, Source
from pickcli.name_suggestion import suggestion

Model = TypeVar("Model", bound="FileModel")

Number = Annotated[float, Field(allow_inf_nan=False)]

# Upper bounds of figures, far beyond those of any real cell; larger values were written in another unit.
Coordinate = Annotated[float, Field(ge=-100, le=100)]  # m
Angle = Annotated[float, Field(ge=-6.3, le=6.3)]  # rad
Size = Annotated[float, Field(gt=0, le=10)]  # m, of objects in a cell
Thickness = Annotated[float, Field(gt=0, le=0.5)]  # m, of boards, posts, cups
Seconds = Annotated[float, Field(ge=0, le=30)]
Force = Annotated[float, Field(gt=0, le=1e6)]  # N, or Nm
Vector = Annotated[tuple[Coordinate, ...], Len(3, 3)]
Angles = Annotated[tuple[Angle, ...], Len(3, 3)]
MAX_TEXT = 200  # characters
Text = Annotated[
    str, Field(min_length=1, max_length=MAX_TEXT, pattern=r"^[^\x00-\x1f\x7f-\x9f]*$")
]  # free text


class FileModel(BaseModel):
    """Base of all models of files: strict types, unknown keys refused, immutable."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True, allow_inf_nan=False)


def not_blank(value: object, unit: str) -> object:
    """Refuse an optional limit whose key has no value: left out means none, left blank means forgotten.

    Args:
        value: The value as written.
        unit: Its unit.

    Returns:
        The value.

    Raises:
        ValueError: It is null.
    """
    if value is None:
        raise ValueError(f"expected a number, got nothing; give it in {unit}, or leave the key out")
    return value


def validate(source: Source, model: type[Model]) -> Model:
    """Check the content of a file against a model.

    Args:
        source: The values of the file, with their positions.
        model: Model of the file.

    Returns:
        The content as an instance of ``model``.

    Raises:
        InputError: With all mistakes, each with its position.
    """
    try:
        # Validated as JSON, where lists can become tuples while everything else is strict.
        return model.model_validate_json(json.dumps(source.data))
    except ValidationError as error:
        details = causes(error)
        for detail in details[:MAX_REPORTED]:
            note(source, model, detail)
        source.n_unreported += len(details[MAX_REPORTED:])
        source.check()
        raise


def causes(error: ValidationError) -> list[Any]:
    """Filter pydantic's errors, removing those that follow from others.

    pydantic reports a list with wrong entries also as too short, because it counts only valid ones. Many
    missing keys of one object are combined into one error.

    Args:
        error: The exception of pydantic.

    Returns:
        Entries of ``ValidationError.errors()``; many missing keys of one object are replaced by one entry of
        type ``MANY_MISSING``.
    """
    details = error.errors(include_url=False)
    inner = {detail["loc"][:i] for detail in details for i in range(len(detail["loc"]))}
    reported: list[Any] = [d for d in details if d["type"] != "too_short" or d["loc"] not in inner]
    missing: dict[Key, list[Any]] = {}
    for detail in reported:
        if detail["type"] == "missing":
            missing.setdefault(detail["loc"][:-1], []).append(detail)
    for parent, group in missing.items():
        if len(group) > FEW_MISSING:
            names = [str(detail["loc"][-1]) for detail in group]
            reported[reported.index(group[0])] = {"type": MANY_MISSING, "loc": parent, "input": names}
            reported = [detail for detail in reported if detail not in group]
    return reported


def note(source: Source, model: type[BaseModel], detail: Any) -> None:
    """Add a pydantic error to the problems of a source.

    Args:
        source: The validated values; receives the problem.
        model: The model used for validation.
        detail: The error, an entry of ``ValidationError.errors()``.
    """
    key: Key = detail["loc"]
    if key[-1:] == (KEY_MARK,) and detail["type"] != "extra_forbidden":
        key = key[:-1]
    key = _without_tags(model, key)
    # In a discriminated union, pydantic's location contains the kind, which is not a key of the file.
    place = tuple(part for i, part in enumerate(key) if not _is_tagged(_annotation(model, key[:i])))
    for part in (place, place[:-1]):  # a list, or a number in it
        if _is_of_commas(value := _value(source.data, part)):
            text = (
                f"expected numbers with a decimal point, got {_short(value)}; a comma begins the next number"
            )
            source.add(part, text)
            return
    is_of_kind = detail["type"] in (UNKNOWN_TAG, NO_TAG)
    source.add((*place, TAG) if is_of_kind else place, explain(model, key, detail))


def _value(data: Any, key: Key) -> Any:
    """The value at a key, None without one."""
    for part in key:
        known = data if isinstance(data, dict) else range(len(data)) if isinstance(data, list) else ()
        if part not in known:
            return None
        data = data[part]
    return data


def _is_of_commas(value: Any) -> bool:
    """Whether a list was written with decimal commas: [0,394, 0,294] has four whole numbers."""
    if not isinstance(value, list) or len(value) < 4 or len(value) % 2:
        return False
    is_whole = all(isinstance(number, int) and not isinstance(number, bool) for number in value)
    return is_whole and max(value[1::2]) >= 10 > max(map(abs, value[::2]))


def explain(model: type[BaseModel], key: Key, detail: Any) -> str:
    """Format a pydantic error as "expected, got; what to do".

    Args:
        model: The model used for validation.
        key: Key of the value in the file.
        detail: The error, an entry of ``ValidationError.errors()``.

    Returns:
        The message, without the position.
    """
    kind, given = detail["type"], detail["input"]
    if kind == "missing":
        return f"expected {_meaning(model, key)}, got nothing; {_addition(model, key)}"
    if kind == MANY_MISSING:
        return f"lacks {', '.join(given[:-1])} and {given[-1]}; {_addition(model, key, 'add them')}"
    if kind == NO_TAG:
        return f"expected {_kinds(model, key)}, got nothing; add it"
    if kind == UNKNOWN_TAG:
        return f"expected {_kinds(model, key)}, got {_short(detail['ctx']['tag'])}; correct it"
    if kind == "extra_forbidden":
        if str(key[-1]).isdecimal():
            return "unknown key, the rest of a number with a decimal comma; write a point"
        known = sorted(_fields(model, key[:-1]))
        return f"unknown key; {suggestion(str(key[-1]), known)}"
    if kind == "value_error":
        return str(detail["ctx"]["error"])
    is_blank = given is None and key and isinstance(key[-1], str)  # a key without a value
    if is_blank and _meaning(model, key) != NO_MEANING:
        return f"expected {_meaning(model, key)}, got nothing; {_addition(model, key, 'fill it in')}"
    meaning = _meaning(model, key)
    advice = _unit(meaning) if _is_far_off(detail) else "correct it"
    if kind in _NUMBERS and isinstance(given, str):
        advice = _number_advice(given, meaning)
    got = f"{len(given)}" if kind in _BOUNDS else _short(given)
    return f"expected {_wanted(model, key, detail)}, got {got}; {advice}"


def _kinds(model: type[BaseModel], key: Key) -> str:
    """Kinds of the union at ``key``: "bodies, box or grid"."""
    members = get_args(get_args(_annotation(model, key))[0])
    *kinds, last = sorted(tag for m in members for tag in get_args(m.model_fields[TAG].annotation))
    return f"{', '.join(kinds)} or {last}"


def _addition(model: type[BaseModel], key: Key, otherwise: str = "add it") -> str:
    """Advice on a missing value: that of its field, under ``advice``, or a default."""
    field = _fields(model, key[:-1]).get(str(key[-1])) if key else None
    extra = getattr(field, "json_schema_extra", None)
    return str(extra["advice"]) if isinstance(extra, dict) and "advice" in extra else otherwise


def _wanted(model: type[BaseModel], key: Key, detail: Any) -> str:
    """Meaning of a field and its allowed values, without repetition."""
    kind, meaning = detail["type"], _meaning(model, key)
    if kind == "literal_error":
        choices = detail["ctx"]["expected"]
        is_said = all(word.lower() in meaning for word in re.findall(r"\w+", choices))
        return meaning if is_said else choices if meaning == NO_MEANING else f"{meaning}: {choices}"
    if kind in _BOUNDS:
        word, bound = _BOUNDS[kind]
        expected = f"{word} {detail['ctx'][bound]} entries"
    elif kind == PATTERN:
        expected = _NAMES.get(detail["ctx"]["pattern"]) or f"text that matches '{detail['ctx']['pattern']}'"
    else:
        expected = _TYPES.get(kind) or detail["msg"].removeprefix("Input should ")
        expected = re.sub(r"^String should have", "text of", expected)
        expected = expected.removeprefix("be ").removeprefix("have ")
        for number, name in _ANGLES.items():
            expected = re.sub(rf"(?<![\d.]){re.escape(number)}$", name, expected)
    is_part = bool(key) and str(key[-1]) not in _fields(model, key[:-1])  # in a list or mapping
    if meaning == NO_MEANING or (is_part and kind in (*_TYPES, *_BOUNDS, PATTERN)):
        return f"{NO_MEANING} {expected}" if expected.startswith(("less", "greater")) else expected
    is_said = kind in _TYPES and meaning.startswith(expected.split(" {")[0].split(" [")[0])
    return meaning if is_said or meaning.startswith(expected) else f"{meaning}: {expected}"


# JSON's words for pydantic's types.
_TYPES = {"model_type": "an object {...}", "dict_type": "an object {...}", "list_type": "a list [...]",
          "tuple_type": "a list [...]", "string_type": "text in quotes"}  # fmt: skip
_NUMBERS = ("float_type", "float_parsing", "int_type", "int_parsing")
_ANGLES = {repr(math.pi): "3.14159 (pi)", repr(math.pi / 2): "1.5708 (pi/2)"}  # bounds in rad
PATTERN = "string_pattern_mismatch"
_NAMES = {  # by pattern
    r"^[A-Za-z][A-Za-z0-9_]*$": "a name of letters, digits and _, a letter first",
    r"^[A-Za-z0-9_]*$": "letters, digits and _ alone",
    r"^[a-z0-9_]+$": "a name of small letters, digits and _",
    r"^[^\x00-\x1f\x7f-\x9f]*$": "text in one line, without control characters",
    r"^[0-9a-f]{64}$": "64 digits from 0 to f",
}
_BOUNDS = {"too_short": ("at least", "min_length"), "too_long": ("at most", "max_length")}
NO_MEANING = "a value"
KEY_MARK = "[key]"  # last element of pydantic's location if the key itself is wrong
TAG = "kind"  # discriminator of unions of models
NO_TAG, UNKNOWN_TAG = "union_tag_not_found", "union_tag_invalid"
FEW_MISSING = 3  # up to this many missing keys of one object are reported one by one
MANY_MISSING = "many_missing"  # type of the error that combines more
MAX_SHOWN = 40  # characters shown of a wrong value


def _is_far_off(detail: Any) -> bool:
    """Whether a figure is probably in another unit: too large, and not merely negative."""
    if detail["type"] == "greater_than_equal":
        return float(detail["ctx"]["ge"]) < 0.0
    return detail["type"] in ("less_than", "less_than_equal")


def _unit(meaning: str) -> str:
    """Advice on a figure that is far too large: it was probably meant in another unit."""
    found = _UNIT.search(meaning)
    if found is not None:
        return _UNITS[found.group()]
    return "shares are of 1, not per cent" if re.search(r"\b(shares?|factor)\b", meaning) else "correct it"


def _number_advice(text: str, meaning: str) -> str:
    """Advice on a text in place of a number."""
    number = re.fullmatch(r"([-+\u2212]?)(\d*[.,]?\d+)(.*)", text.strip(), re.DOTALL)
    if number is None:
        return "correct it"
    sign, digits, rest = number.groups()
    plain = ("-" if sign in ("-", "\u2212") else "") + digits.replace(",", ".")
    if rest.strip() == "%":
        return f"write {float(plain) / 100:g}, as shares are of 1"
    if rest:
        unit = _UNIT.search(meaning)
        if both := re.search(r"\bm(/s\d?) or rad\1", meaning):  # of a joint
            return f"write the number alone, in rad{both[1]}, or in m{both[1]} for a prismatic joint"
        return f"write the number alone{'' if unit is None else f', in {unit.group()}'}"
    if "," in digits:
        return f"write {plain}, with a point"
    return (
        f"write {plain}, with the minus of the keyboard"
        if sign == "\u2212"
        else f"write {plain}, without quotes"
    )


_UNIT = re.compile(r"(?<![/'\w])(m/s|m|rad|s|kg)\b(?!/| ?\()")
_UNITS = {
    "m/s": "speeds are in m/s, not mm/s",
    "m": "lengths are in m, not mm",
    "rad": "angles are in rad, not degrees",
    "s": "times are in s, not ms",
    "kg": "masses are in kg, not g",
}


def _short(value: Any) -> str:
    """Beginning of a value as JSON, for values of any size."""
    text = ""
    for part in json.JSONEncoder(ensure_ascii=False).iterencode(
        value[:MAX_SHOWN] if isinstance(value, str) else value
    ):
        text += part
        if len(text) > MAX_SHOWN:
            return text[: MAX_SHOWN - 3] + "..."
    return text


def _meaning(model: type[BaseModel], key: Key) -> str:
    """Description of a field; for a value in a list or mapping, that of the whole."""
    while key and isinstance(key[-1], int):
        key = key[:-1]
    siblings = _fields(model, key[:-1])
    if not siblings and len(key) > 1:
        return _meaning(model, key[:-1])
    field = siblings.get(str(key[-1])) if key else None
    if field is None or not field.description:
        return NO_MEANING
    return f"a value in {field.description}" if field.description in _UNITS else str(field.description)


def _fields(model: type[BaseModel], key: Key) -> dict[str, Any]:
    """Fields of the model at ``key`` inside ``model``; empty if there is no model."""
    return _fields_of(_annotation(model, key))


def _annotation(model: type[BaseModel], key: Key) -> Any:
    """Annotation at ``key`` in ``model``, None without one; a tag in the key selects from a union."""
    annotation: Any = model
    for part in key:
        fields = _fields_of(annotation)
        if _is_tagged(annotation):
            annotation = _of_tag(annotation, part)
        elif not fields:
            annotation = _innermost(annotation)
        elif part in fields:
            annotation = _unwrapped(fields[part].annotation)
        else:
            return None
    return annotation


def _fields_of(annotation: Any) -> dict[str, Any]:
    """Fields of a model, or of all members of a discriminated union; empty for anything else."""
    if get_origin(annotation) is Annotated:
        return _fields_of(get_args(annotation)[0])
    if get_origin(annotation) in (Union, UnionType):
        parts = [_fields_of(part) for part in get_args(annotation)]
        return {name: field for part in reversed(parts) for name, field in part.items()}
    fields = getattr(annotation, "model_fields", {})
    return {field.alias or name: field for name, field in fields.items()}


def _is_tagged(annotation: Any) -> bool:
    """Whether an annotation is a union of models discriminated by the key ``kind``."""
    return any(getattr(a, "discriminator", None) == TAG for a in get_args(annotation))


def _without_tags(model: type[BaseModel], key: Key) -> Key:
    """The key without the tags that pydantic inserts for unions with a callable discriminator."""
    found: Key = ()
    is_chosen = False
    for part in key:
        is_chosen = not is_chosen and part in _tags(_annotation(model, found))
        found = found if is_chosen else (*found, part)
    return found


def _tags(annotation: Any) -> set[str]:
    """Tags of a union with a callable discriminator."""
    members = get_args(get_args(annotation)[0]) if get_origin(annotation) is Annotated else ()
    return {each.tag for member in members for each in get_args(member)[1:] if isinstance(each, Tag)}


def _of_tag(annotation: Any, tag: int | str) -> Any:
    """The member of a union with a kind, None without one."""
    members = get_args(get_args(annotation)[0])
    return next((m for m in members if tag in get_args(m.model_fields[TAG].annotation)), None)


def _innermost(annotation: Any) -> Any:
    """Type of the values of a tuple, list or dict annotation."""
    arguments = [a for a in get_args(annotation) if a is not Ellipsis]
    return _unwrapped(arguments[-1]) if arguments else annotation


def _unwrapped(annotation: Any) -> Any:
    """The annotation without None."""
    arguments = get_args(annotation)
    return next(a for a in arguments if a is not type(None)) if type(None) in arguments else annotation
