"""Page of a folder of trials of streams: what was delivered of what came, how it was met, and what failed."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

from pickcli.page.page_document import Bar, Chart, PageDocument, PageTable
from pickcli.page.page_scene import Fact, Tone
from pickcli.stream_trials.published_experiments import COLUMNS, beside_paper
from pickcli.stream_trials.stream_result import ItemOutcome
from pickcli.stream_trials.stream_statistics import StreamStatistics

MOST_CAUSES = 12
_COLOURS = {
    ItemOutcome.DELIVERED: "#009e73",
    ItemOutcome.NOT_ATTEMPTED: "#e69f00",
    ItemOutcome.LOST: "#b2182b",
}


def stream_trials_page(records: Mapping[str, Mapping[str, Any]]) -> PageDocument:
    """Create a page of several trials of streams.

    Args:
        records: Contents of their ``trial.json``, by name.

    Returns:
        The page.
    """
    statistics = StreamStatistics(records)
    return PageDocument(
        kind="stream trials",
        title=f"{len(records)} trials of streams",
        subtitle=f"{len(statistics.items)} items",
        facts=(
            Fact("delivered", statistics.delivered.text),
            Fact("of those attempted", statistics.delivered_of_attempted.text),
            Fact("pace", f"{statistics.delivered_per_minute:.1f} delivered a minute"),
            *(_total(statistics, key) for key in ("collisions", "limit_violations", "stops")),
            *_met(statistics),
        ),
        charts=(_by_trial(records), _by_item(statistics)),
        tables=(
            _trials(records),
            _items(statistics),
            _causes("Why items were not attempted", statistics.causes(ItemOutcome.NOT_ATTEMPTED)),
            _causes("Why items were lost", statistics.causes(ItemOutcome.LOST)),
            *paper_tables(records),
        ),
    )


def paper_tables(records: Mapping[str, Mapping[str, Any]]) -> tuple[PageTable, ...]:
    """Make tables of the experiments of the PR2 paper of 2013 beside trials of the streams after them.

    Args:
        records: Contents of ``trial.json`` files of streams, by name.

    Returns:
        The tables; none if no such stream was played.
    """
    return tuple(PageTable(each.title, COLUMNS, each.rows) for each in beside_paper(records))


def _total(statistics: StreamStatistics, key: str) -> Fact:
    total = statistics.total(key)
    return Fact(key.replace("_", " "), str(total), Tone.BAD if total else Tone.PLAIN)


def _met(statistics: StreamStatistics) -> tuple[Fact, ...]:
    """How items were met, if any was."""
    offset, slip = statistics.met("offset_m"), statistics.met("slip_m_s")
    if offset is None or slip is None:
        return ()
    return (
        Fact(
            "tool off its place",
            f"{1e3 * offset['p95']:.1f} mm in 95 % of the picks, at most {1e3 * offset['worst']:.1f} mm",
        ),
        Fact(
            "tool over the item",
            f"{1e3 * slip['p95']:.1f} mm/s along the belt in 95 %, at most {1e3 * slip['worst']:.1f} mm/s",
        ),
    )


def _counts(items: Sequence[Mapping[str, Any]]) -> tuple[int, ...]:
    counts = Counter(item["outcome"] for item in items)
    return tuple(counts[outcome] for outcome in _COLOURS)


def _chart(title: str, bars: tuple[Bar, ...]) -> Chart:
    return Chart(title, tuple((str(outcome), colour) for outcome, colour in _COLOURS.items()), bars)


def _by_trial(records: Mapping[str, Mapping[str, Any]]) -> Chart:
    bars = tuple(Bar(name, _counts(record["items"])) for name, record in records.items())
    return _chart("Items by trial", bars)


def _by_item(statistics: StreamStatistics) -> Chart:
    bars = tuple(Bar(name, _counts(items)) for name, items in statistics.items_by_name.items())
    return _chart("Items by name", bars)


def _trials(records: Mapping[str, Mapping[str, Any]]) -> PageTable:
    rows = tuple(
        (name, f"{r['speed_m_s']:g} m/s", str(r["rule"]), f"{r['delivered']}", f"{r['attempted']}",
         f"{r['presented']}", f"{r['delivered_per_minute']:.1f}", f"{r['collisions']}",
         f"{r['limit_violations']}", f"{r['stops']}")
        for name, r in records.items()
    )  # fmt: skip
    tones = tuple(
        Tone.BAD if r["collisions"] or r["limit_violations"] else Tone.PLAIN for r in records.values()
    )
    columns = ("trial", "belt", "rule", "delivered", "attempted", "presented", "a minute", "collisions",
               "limit violations", "stops")  # fmt: skip
    return PageTable("Trials", columns, rows, tones)


def _items(statistics: StreamStatistics) -> PageTable:
    rows = tuple((name, rate.text) for name, rate in statistics.by_item.items())
    return PageTable("Delivered by item", ("item", "share"), rows)


def _causes(title: str, causes: Sequence[tuple[int, str]]) -> PageTable:
    rows = tuple((str(n), why) for n, why in causes[:MOST_CAUSES])
    return PageTable(title, ("items", "why"), rows or (("0", "none"),))
