"""Suggest the known name that was probably meant by an unknown one."""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence

MAX_NAME = 60  # characters of an unknown name that are compared and repeated
MAX_KNOWN = 16  # names that are listed where none is like the one given
MAX_MEANT = 3  # names that are suggested
MIN_PREFIX = 3  # letters that a name begins with to be meant by them


def shortened(name: str, most: int = MAX_NAME) -> str:
    """A name as it is repeated in a message: cut if it is too long.

    Args:
        name: The name.
        most: Characters that are kept, at most.

    Returns:
        The name, with an ellipsis if it was cut.
    """
    return name if len(name) <= most else name[:most] + "..."


def suggestion(name: str, known: Collection[str]) -> str:
    """What to write instead of an unknown name.

    Args:
        name: As it was given.
        known: What could have been meant.

    Returns:
        "did you mean 'bin_C'?" with the names that differ in case and separators alone, else those that
        contain the name as words (`A` for `bin_A`), else those that begin with it, else those spelt most
        alike. Without any, or with too many that are equally alike, the known names.
    """
    if meant := _meant(name[:MAX_NAME], sorted(known)):
        return f"did you mean {' or '.join(map(repr, meant))}?"
    listed = ", ".join(sorted(known)[:MAX_KNOWN]) + (", ..." if len(known) > MAX_KNOWN else "")
    return f"known: {listed or 'none'}"


def _meant(name: str, known: Sequence[str]) -> Sequence[str]:
    """The known names that are meant most likely, at most MAX_MEANT."""
    import difflib

    words = _words(name)
    if not words:
        return ()
    if same := [other for other in known if "".join(_words(other)) == "".join(words)]:
        return same[:1]
    holding = [other for other in known if _holds(_words(other), words)]
    if 0 < len(holding) <= MAX_MEANT:
        return holding
    beginning = [
        other for other in known if len(name) >= MIN_PREFIX and other.lower().startswith(name.lower())
    ]
    if 0 < len(beginning) <= MAX_MEANT:
        return beginning
    closest = difflib.get_close_matches(name, known, n=MAX_MEANT + 1)
    ratios = [difflib.SequenceMatcher(None, other, name).ratio() for other in closest]
    alike = [other for other, ratio in zip(closest, ratios, strict=True) if ratio == ratios[0]]
    return alike if len(alike) <= MAX_MEANT else ()


def _words(name: str) -> list[str]:
    """The words of a name, in lower case."""
    return re.findall(r"[^\W_]+", name.lower())


def _holds(words: Sequence[str], part: Sequence[str]) -> bool:
    """Whether some words hold others, side by side and in their order."""
    n = len(part)
    return any(list(words[i : i + n]) == list(part) for i in range(len(words) - n + 1))
