"""Suggestion of the known names that an unknown name probably stands for."""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence

MAX_NAME = 60  # characters of an unknown name that are compared and repeated
MAX_KNOWN = 16  # names that are listed if none is similar to the given one
MAX_MEANT = 3  # names that are suggested
MIN_PREFIX = 3  # least letters of a name for a suggestion of names that begin with it


def shortened(name: str, most: int = MAX_NAME) -> str:
    """Shorten a name for a message if it is too long.

    Args:
        name: The name.
        most: Most characters to keep.

    Returns:
        The name, with an ellipsis if it was cut.
    """
    return name if len(name) <= most else name[:most] + "..."


def suggestion(name: str, known: Collection[str]) -> str:
    """Suggest what to write instead of an unknown name.

    Args:
        name: The name as given.
        known: The possible names.

    Returns:
        "did you mean 'bin_C'?" with the names that differ only in case and separators, else those that
        contain the name as words (`A` for `bin_A`), else those that begin with it, else the most similar
        ones. Without any, or with too many that are equally similar, the known names.
    """
    if meant := _meant(name[:MAX_NAME], sorted(known)):
        return f"did you mean {' or '.join(map(repr, meant))}?"
    apart = "; " if any("," in each for each in known) else ", "
    listed = apart.join(sorted(known)[:MAX_KNOWN]) + (f"{apart}..." if len(known) > MAX_KNOWN else "")
    return f"known: {listed or 'none'}"


def _meant(name: str, known: Sequence[str]) -> Sequence[str]:
    """Return the most probable known names, at most MAX_MEANT."""
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
    """Split a name into words, in lower case."""
    return re.findall(r"[^\W_]+", name.lower())


def _holds(words: Sequence[str], part: Sequence[str]) -> bool:
    """Whether a sequence of words contains another one contiguously."""
    n = len(part)
    return any(list(words[i : i + n]) == list(part) for i in range(len(words) - n + 1))
