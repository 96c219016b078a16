"""The page of a folder of trials: scores, what became of every target, why items were missed."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from pickcli.page.page_document import Bar, Chart, PageDocument, PageTable
from pickcli.page.page_scene import Fact, Tone

MOST_CAUSES = 12
_GOOD, _FAIR, _BAD = "#009e73", "#e69f00", "#b2182b"
_FIGURE = re.compile(r"[-+]?\d+(?:\.\d+)?")


def trials_page(records: Mapping[str, Mapping[str, Any]]) -> PageDocument:
    """Show several trials side by side.

    Args:
        records: What their ``trial.json`` say, by name.

    Returns:
        The page.
    """
    shares = np.array([r["score"] / max(1, r["max_score"]) for r in records.values()])
    items = [(item, name) for name, r in records.items() for item in r["items"]]
    delivered = sum(item["points"] > 0 for item, _ in items)
    return PageDocument(
        kind="trials",
        title=f"{len(records)} trials",
        subtitle=f"{len(items)} targets",
        facts=(
            Fact("score", f"{shares.mean():.0%} of the most in the mean, {shares.min():.0%} in the worst"),
            Fact("delivered", f"{delivered} of {len(items)} targets, {delivered / max(1, len(items)):.0%}"),
            *(_total(records, key, label) for key, label in (
                ("collisions", "collisions"), ("limit_violations", "limit violations"),
                ("drops", "items lost"), ("disturbed", "items moved"),
            )),
            Fact("aborted", str(sum(bool(r["aborted"]) for r in records.values()))),
        ),
        charts=(_by_place([item for item, _ in items]), _by_item([item for item, _ in items])),
        tables=(_scores(records), _causes([item for item, _ in items])),
    )  # fmt: skip


def _total(records: Mapping[str, Mapping[str, Any]], key: str, label: str) -> Fact:
    total = sum(record[key] for record in records.values())
    return Fact(label, str(total), Tone.BAD if total else Tone.PLAIN)


def _scores(records: Mapping[str, Mapping[str, Any]]) -> PageTable:
    rows, tones = [], []
    for name, record in records.items():
        rows.append((
            name, f"{record['score']}", f"{record['max_score']}", f"{record['items_in_tote']}",
            f"{len(record['items'])}", f"{record['collisions']}", f"{record['clock_s']:.0f} s",
        ))  # fmt: skip
        tones.append(Tone.BAD if record["aborted"] or record["collisions"] else Tone.PLAIN)
    columns = ("trial", "score", "of", "delivered", "of", "collisions", "clock")
    return PageTable("Trials", columns, tuple(rows), tuple(tones))


def _by_place(items: Sequence[Mapping[str, Any]]) -> Chart:
    return _outcomes("Targets by place", items, "bin")


def _by_item(items: Sequence[Mapping[str, Any]]) -> Chart:
    return _outcomes("Targets by item", items, "item")


def _outcomes(title: str, items: Sequence[Mapping[str, Any]], key: str) -> Chart:
    """How many targets were delivered, tried in vain, and never planned for."""
    counts: dict[str, list[int]] = {}
    for item in sorted(items, key=lambda item: str(item[key])):
        kind = 0 if item["points"] > 0 else 2 if item["outcome"] == "no plan" else 1
        counts.setdefault(item[key].replace("_", " "), [0, 0, 0])[kind] += 1
    kinds = (("delivered", _GOOD), ("tried in vain", _FAIR), ("no plan", _BAD))
    return Chart(title, kinds, tuple(Bar(name, tuple(count)) for name, count in counts.items()))


def _causes(items: Sequence[Mapping[str, Any]]) -> PageTable:
    """Why targets were missed, the most frequent first; figures in the reasons make no difference."""
    causes = Counter(
        f"{item['outcome']}: {_FIGURE.sub('…', item['reason']) or 'no reason told'}"[:160]
        for item in items
        if item["points"] <= 0
    )
    rows = tuple((str(n), cause) for cause, n in causes.most_common(MOST_CAUSES))
    return PageTable("Why targets were missed", ("targets", "why"), rows or (("0", "none was missed"),))
