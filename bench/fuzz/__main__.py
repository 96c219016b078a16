"""``python -m bench.fuzz``: broken inputs by the thousand; exit code 1 if one is more than refused."""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

from bench.fuzz.sandbox import FAILURES, Limits, Outcome, Result, counted, tried
from bench.fuzz.targets import Kind, kinds, sound

TOLD = 20  # failures that are listed


def main() -> None:
    """Try all kinds in turn and print what became of them."""
    options = _options()
    limits = Limits(options.seconds, options.megabytes)
    failures: list[tuple[Kind, Result]] = []
    print(f"{'input':<26}{'cases':>7}" + "".join(f"{outcome:>11}" for outcome in Outcome))
    with tempfile.TemporaryDirectory() as folder:
        for kind in kinds(sound(), Path(folder), options.seed):
            if options.only is not None and options.only not in kind.name:
                continue
            n = max(1, round(options.cases * kind.share))
            first = options.first
            results = list(tried(kind.attempt, range(first, first + n), limits))
            counts = counted(results)
            print(
                f"{kind.name:<26}{n:>7}" + "".join(f"{counts[outcome]:>11}" for outcome in Outcome),
                flush=True,
            )
            failures += [(kind, result) for result in results if result.outcome in FAILURES]
    _tell(failures, options.seed)
    sys.exit(1 if failures else 0)


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m bench.fuzz", description=__doc__)
    parser.add_argument("--cases", type=int, default=20_000, help="of all kinds together")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", help="kinds whose name holds this text")
    parser.add_argument("--first", type=int, default=0, help="number of the first case of each kind")
    parser.add_argument("--seconds", type=float, default=Limits.seconds, help="of CPU time for one case")
    parser.add_argument("--megabytes", type=int, default=Limits.megabytes, help="of memory for one case")
    return parser.parse_args()


def _tell(failures: list[tuple[Kind, Result]], seed: int) -> None:
    """Each place that failed once, with the case that does it again."""
    seen: dict[str, list[tuple[Kind, Result]]] = {}
    for kind, result in failures:
        seen.setdefault(f"{kind.name}: {result.outcome}: {result.where}", []).append((kind, result))
    print(f"{len(failures)} failures" + (f" in {len(seen)} places" if failures else ""))
    for what, found in list(seen.items())[:TOLD]:
        again = f'--only "{found[0][0].name}" --cases 1 --first {found[0][1].case} --seed {seed}'
        print(f"  {len(found)} x {what}\n    python -m bench.fuzz {again}")


if __name__ == "__main__":
    main()
