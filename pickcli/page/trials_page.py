"""Page of a folder of trials: scores, success rates by item, and causes of failures."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

from pickcli.monte_carlo.sign_flips import FEWEST
from pickcli.monte_carlo.success_rate import SuccessRate
from pickcli.monte_carlo.trial_statistics import TrialStatistics, score_share
from pickcli.page.page_document import Bar, Chart, PageDocument, PageTable
from pickcli.page.page_scene import Fact, Tone

MOST_CAUSES = 12
BAR_WIDTH = 0.1  # width of a bar, as a share of the largest score
_GOOD, _FAIR, _BAD = "#009e73", "#e69f00", "#b2182b"


def trials_page(records: Mapping[str, Mapping[str, Any]]) -> PageDocument:
    """Create a page of several trials.

    Args:
        records: Contents of their ``trial.json``, by name.

    Returns:
        The page.
    """
    statistics = TrialStatistics(records)
    rate, items = statistics.delivered, statistics.targets
    return PageDocument(
        kind="trials",
        title=f"{len(records)} trials",
        subtitle=f"{len(items)} targets",
        facts=(
            Fact("score", _mean(statistics)),
            Fact("delivered", f"{rate.successes} of {rate.tries} targets, {_share(rate)}"),
            *(_total(statistics, key, label) for key, label in (
                ("collisions", "collisions"), ("limit_violations", "limit violations"),
                ("drops", "items lost"), ("disturbed", "items disturbed"),
            )),
            Fact("aborted", str(statistics.total("aborted"))),
            Fact("failed in", ", ".join(f"{stage} {n}" for stage, n in statistics.failed_in.items())),
        ),
        charts=(_distribution(statistics.shares), _by_place(items), _by_item(items)),
        tables=(
            _scores(records),
            _rates("Success by place", statistics.by("bin")),
            _rates("Success by item", statistics.by("item")),
            _causes(statistics.causes),
        ),
    )  # fmt: skip


def _mean(statistics: TrialStatistics) -> str:
    """Mean score with its interval, and the worst score."""
    test, worst = statistics.mean_share, min(statistics.shares)
    between = f" (95 %: {test.low:.0%} to {test.high:.0%})" if test.n >= FEWEST else ""
    return f"mean {test.mean:.0%} of the maximum score{between}, worst {worst:.0%}"


def _share(rate: SuccessRate) -> str:
    if not rate.tries:
        return "none"
    low, high = rate.interval
    return f"{rate.share:.0%} (95 %: {low:.0%} to {high:.0%})"


def _total(statistics: TrialStatistics, key: str, label: str) -> Fact:
    total = statistics.total(key)
    return Fact(label, str(total), Tone.BAD if total else Tone.PLAIN)


def _distribution(shares: Sequence[float]) -> Chart:
    """Histogram of score shares in tenths; negative shares count as 0."""
    counts = Counter(min(9, max(0, int(share / BAR_WIDTH + 1e-9))) for share in shares)
    bars = tuple(Bar(f"{10 * k} to {10 * k + 10} %", (counts[k],)) for k in range(min(counts), 10))
    return Chart("Trials by their share of the points", (("trials", _GOOD),), bars)


def _scores(records: Mapping[str, Mapping[str, Any]]) -> PageTable:
    rows, tones = [], []
    for name, record in records.items():
        rows.append((
            name, f"{record['score']}", f"{record['max_score']}", f"{score_share(record):.0%}",
            f"{record['items_in_tote']}", f"{len(record['items'])}", f"{record['collisions']}",
            f"{record['clock_s']:.0f} s",
        ))  # fmt: skip
        tones.append(Tone.BAD if record["aborted"] or record["collisions"] else Tone.PLAIN)
    columns = ("trial", "score", "of", "share", "delivered", "of", "collisions", "clock")
    return PageTable("Trials", columns, tuple(rows), tuple(tones))


def _by_place(items: Sequence[Mapping[str, Any]]) -> Chart:
    return _outcomes("Targets by place", items, "bin")


def _by_item(items: Sequence[Mapping[str, Any]]) -> Chart:
    return _outcomes("Targets by item", items, "item")


def _outcomes(title: str, items: Sequence[Mapping[str, Any]], key: str) -> Chart:
    """Numbers of targets that were delivered, tried without success, and never planned."""
    counts: dict[str, list[int]] = {}
    for item in sorted(items, key=lambda item: str(item[key])):
        kind = 0 if item["points"] > 0 else 2 if item["outcome"] == "no plan" else 1
        counts.setdefault(item[key].replace("_", " "), [0, 0, 0])[kind] += 1
    kinds = (("delivered", _GOOD), ("failed", _FAIR), ("no plan", _BAD))
    return Chart(title, kinds, tuple(Bar(name, tuple(count)) for name, count in counts.items()))


def _rates(title: str, rates: Mapping[str, SuccessRate]) -> PageTable:
    """Success rates with their intervals, the worst first."""
    ranked = sorted(rates.items(), key=lambda named: (named[1].share, named[0]))
    rows = tuple(
        (name.replace("_", " "), str(rate.successes), str(rate.tries), _share(rate)) for name, rate in ranked
    )
    return PageTable(title, ("name", "delivered", "of", "share"), rows)


def _causes(causes: Sequence[tuple[int, str]]) -> PageTable:
    rows = tuple((str(n), cause) for n, cause in causes[:MOST_CAUSES])
    return PageTable("Why targets were missed", ("targets", "why"), rows or (("0", "none was missed"),))
