"""Points by camera beside points by bounded noise: the same fresh orders and scenes, played both ways.

    python -m bench.camera_trials --orders 3 --seed 1421004 [--sift auto] [--json FILE]

Orders are those of ``apc make-order`` with the seeds from --seed on; each is played by ``apc run-trial
--seed 1`` with ``--perception noise`` and ``camera``, one after the other. Trials are kept under runs/camera,
so that the same command goes on where it was interrupted; remove that folder after a change of the program. A
bound is kept if a believed pose is truly within it, in position, angle and surface, in every look. Of each
target that noise delivers and the camera does not, the outcome by camera is told, and of each bound that was
not kept by how much.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pickcli.trial.make_order import make_order
from pickcli.trial.order import OrderKind
from pickcli.trial.output_file import write_output
from pickcli.trial.trial_record import read_record

FOLDER = Path("runs/camera")
YEAR, TRIAL_SEED = 2016, 1
KINDS = ("noise", "camera")
ENDED = (0, 6)  # exit codes of a trial that was played, clean or not
ERRORS = ("mm", "deg", "surface_mm")
ASKED = 0.8  # share of the points by noise


@dataclass(frozen=True)
class Comparison:
    """One order that was played both ways.

    Attributes:
        seed: Its seed.
        noise: Record of the trial by noise.
        camera: That by camera.
    """

    seed: int
    noise: Mapping[str, Any]
    camera: Mapping[str, Any]

    @property
    def bounds(self) -> tuple[int, int]:
        """How many poses were believed in all looks, and how many of these were off by more than bounds."""
        return len(self._believed), sum(not is_kept(each) for each in self._believed)

    @property
    def broken(self) -> list[str]:
        """Poses that are off by more than their bounds: where, by how much, and what was stated."""
        return [
            f"{each['place']} {each['item']} is off by {_told(each, 'truly_off')}, "
            f"stated {_told(each, 'bound')}"
            for each in self._believed
            if not is_kept(each)
        ]

    @property
    def _believed(self) -> list[Mapping[str, Any]]:
        return [i for look in self.camera["looks"] for i in look["items"] if i["bound_mm"] is not None]

    @property
    def lost(self) -> list[str]:
        """Targets that noise delivers and the camera does not, with points and outcome."""
        pairs = zip(self.noise["items"], self.camera["items"], strict=True)
        return [
            f"{by_noise['bin']} {by_noise['item']} ({by_noise['points']}): {by_camera['outcome']}, "
            f"{by_camera['reason']}"
            for by_noise, by_camera in pairs
            if by_noise["points"] > 0 and by_camera["points"] <= 0
        ]


def is_kept(item: Mapping[str, Any]) -> bool:
    """Whether a believed pose is truly within its bounds; not if the item is gone."""
    if item["truly_off_mm"] is None:
        return False
    pairs = [(item[f"truly_off_{name}"], item[f"bound_{name}"]) for name in ERRORS]
    return all(off is None or bound is None or off <= bound for off, bound in pairs)


def _told(item: Mapping[str, Any], what: str) -> str:
    """Its errors or bounds: mm, degrees, and mm of the surface."""
    return ", ".join(
        "none" if item[f"{what}_{name}"] is None else f"{item[f'{what}_{name}']:.1f}" for name in ERRORS
    )


def played(seed: int, kind: str, sift: str) -> Mapping[str, Any]:
    """Play an order, unless it was played; return the record. Raises SystemExit if that fails."""
    order, folder = FOLDER / f"{seed}.json", FOLDER / f"{seed}-{kind}"
    if not (folder / "after.png").exists():  # it is written last
        FOLDER.mkdir(parents=True, exist_ok=True)
        write_output(order, make_order(OrderKind.PICK, YEAR, seed))
        options = ["--seed", str(TRIAL_SEED), "--perception", kind, "-o", str(folder), "--overwrite"]
        options += ["--sift", sift] if kind == "camera" else []
        command = [sys.executable, "-m", "pickcli", "run-trial", str(order), *options]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode not in ENDED:
            raise SystemExit(f"order {seed} by {kind}: {done.stderr.strip()[-500:]}")
    return read_record(folder / "trial.json")


def row(name: str, compared: Sequence[Comparison]) -> str:
    """One row of the table, over one order or all."""
    points = [sum(getattr(each, kind)["score"] for each in compared) for kind in KINDS]
    most = sum(each.noise["max_score"] for each in compared)
    believed, broken = (sum(numbers) for numbers in zip(*(each.bounds for each in compared), strict=True))
    contacts = ", ".join(str(sum(getattr(each, kind)["collisions"] for each in compared)) for kind in KINDS)
    scored = f"{points[0]} of {most} | {points[1]} | {points[1] / max(points[0], 1):.0%}"
    return f"| {name} | {scored} | {believed}, {broken} | {contacts} |"


def main() -> None:
    """Play, and print the table and what is lost."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--orders", type=int, default=3)
    parser.add_argument("--seed", type=int, required=True, help="of the first order, used for nothing else")
    parser.add_argument("--sift", default="auto", help="how prints are looked for")
    parser.add_argument("--json", type=Path, help="also write points and bounds there")
    given = parser.parse_args()
    compared = []
    print(f"| order | by noise | by camera | share ({ASKED:.0%}) | poses believed, broken | contacts |")
    print("|---|---|---|---|---|---|")
    for seed in range(given.seed, given.seed + given.orders):
        compared.append(Comparison(seed, *(played(seed, kind, given.sift) for kind in KINDS)))
        print(row(f"`{seed}`", compared[-1:]), flush=True)
    print(row("all", compared))
    for each in compared:
        for told in (*each.lost, *each.broken):
            print(f"{each.seed}: {told}")
    if given.json is not None:
        points = {
            str(each.seed): {
                "noise": each.noise["score"],
                "camera": each.camera["score"],
                "bounds": each.bounds,
            }
            for each in compared
        }
        given.json.write_text(json.dumps(points, indent=1) + "\n")


if __name__ == "__main__":
    main()
