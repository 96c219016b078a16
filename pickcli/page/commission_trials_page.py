"""Page of a folder of trials of commissions: how often the chain succeeds, how fast, and what fails."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from math import floor
from typing import Any

from pickcli.commission.commission_statistics import TOTALS, CommissionStatistics, why_no_success
from pickcli.monte_carlo.trial_statistics import spread
from pickcli.page.page_document import Bar, Chart, PageDocument, PageTable
from pickcli.page.page_scene import Fact, Tone

MOST_CAUSES = 12
STEP = 10  # s of a bar
_GOOD, _BAD = "#009e73", "#b2182b"


def commission_trials_page(records: Mapping[str, Mapping[str, Any]]) -> PageDocument:
    """Create a page of several trials of commissions.

    Args:
        records: Contents of their ``trial.json``, by name.

    Returns:
        The page.
    """
    statistics = CommissionStatistics(records)
    return PageDocument(
        kind="commission trials",
        title=f"{len(records)} trials of commissions",
        subtitle=f"{len(statistics.items)} items",
        facts=(
            Fact("success", statistics.success.text),
            Fact("items in place", statistics.placed.text),
            Fact("delivered", statistics.delivered.text),
            Fact("time", _seconds(statistics.durations)),
            Fact("at the load", _seconds(statistics.handling)),
            *(_total(statistics, key) for key in (*TOTALS, "aborted")),
            *_people(statistics),
        ),
        charts=(_times(records), _steps(statistics)),
        tables=(_trials(records), _step_table(statistics), _products(statistics), _causes(statistics),
                _failed(statistics)),
    )  # fmt: skip


def _seconds(values: list[float]) -> str:
    found = spread(values)
    return f"median {found['median']:.0f} s, 90 % within {found['p90']:.0f} s, at most {found['max']:.0f} s"


def _total(statistics: CommissionStatistics, key: str) -> Fact:
    total = statistics.total(key)
    return Fact(key.replace("_", " "), str(total), Tone.BAD if total else Tone.PLAIN)


def _people(statistics: CommissionStatistics) -> tuple[Fact, ...]:
    """What watched drives tell of people, if there are any."""
    people = statistics.people
    if people is None:
        return ()
    braked = people["braked_s"]
    return (
        Fact("people", f"{people['number']} came, {people['walked_in']} walked into the truck"),
        Fact("people touched", str(people["touched"]), Tone.BAD if people["touched"] else Tone.PLAIN),
        Fact("braked for them", f"median {braked['median']:.1f} s a trial, at most {braked['max']:.1f} s"),
    )


def _times(records: Mapping[str, Mapping[str, Any]]) -> Chart:
    """Histogram of the durations, of successes and others."""
    counts = Counter((floor(r["duration_s"] / STEP), bool(r["success"])) for r in records.values())
    whole = [k for k, _ in counts]
    bars = tuple(
        Bar(f"{STEP * k} to {STEP * (k + 1)} s", (counts[k, True], counts[k, False]))
        for k in range(min(whole), max(whole) + 1)
    )
    return Chart("Trials by their time", (("success", _GOOD), ("no success", _BAD)), bars)


def _steps(statistics: CommissionStatistics) -> Chart:
    bars = []
    for name, steps in statistics.steps.items():
        failed = sum(not each["is_success"] for each in steps)
        bars.append(Bar(name, (len(steps) - failed, failed)))
    return Chart("Steps", (("done", _GOOD), ("failed", _BAD)), tuple(bars))


def _trials(records: Mapping[str, Mapping[str, Any]]) -> PageTable:
    rows = tuple(
        (name, "success" if r["success"] else "no success", f"{r['items_placed']}", f"{r['items_ordered']}",
         f"{r['duration_s']:.0f} s", f"{r['handling_s']:.0f} s", f"{r['collisions']}",
         "" if r["success"] else why_no_success(r))
        for name, r in records.items()
    )  # fmt: skip
    tones = tuple(Tone.PLAIN if r["success"] else Tone.BAD for r in records.values())
    columns = ("trial", "", "items", "of", "time", "at the load", "collisions", "why")
    return PageTable("Trials", columns, rows, tones)


def _step_table(statistics: CommissionStatistics) -> PageTable:
    rows = []
    for name, steps in statistics.steps.items():
        took = spread([each["t_end"] - each["t_start"] for each in steps])
        failed = sum(not each["is_success"] for each in steps)
        rows.append((name, str(len(steps)), str(failed), f"{took['median']:.1f} s", f"{took['max']:.1f} s"))
    return PageTable("Steps", ("step", "number", "failed", "median", "longest"), tuple(rows))


def _products(statistics: CommissionStatistics) -> PageTable:
    rows = tuple((name, rate.text) for name, rate in statistics.by_product.items())
    return PageTable("Items in place by product", ("product", "share"), rows)


def _causes(statistics: CommissionStatistics) -> PageTable:
    rows = tuple((str(n), cause) for n, cause in statistics.causes[:MOST_CAUSES])
    return PageTable("Why trials were no success", ("trials", "why"), rows or (("0", "all were"),))


def _failed(statistics: CommissionStatistics) -> PageTable:
    rows = tuple((str(n), why) for n, why in statistics.failed_steps[:MOST_CAUSES])
    return PageTable("Steps that failed", ("steps", "why"), rows or (("0", "none failed"),))
