"""Writes the folder of a trial of a pallet. Its files are described in docs/formats/trial.md."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

from pickcli.cell.schemas.items_text import items_text
from pickcli.files.atomic_write import write_text
from pickcli.pallet_trials.pallet_station import PalletStation
from pickcli.pallet_trials.pallet_trial import PlayedPallet
from pickcli.palletizing.carton_item import carton_item
from pickcli.palletizing.pallet_stack_file import StackedPallet, write_stacked_pallet
from pickcli.scene.scene_file import write_scene
from pickcli.trial.motion_record import motion_values, write_motion
from pickcli.trial.scene_plan import plan_writers
from pickcli.trial.trial_folder import MOTION, RECORD, write_files
from pickcli.trial.trial_record import record_digest, write_record

STACK, ITEMS, AFTER = "stack.json", "items.yaml", "after.json"
NAMES = (STACK, ITEMS, AFTER, MOTION, RECORD)


def write_pallet_folder(
    folder: Path,
    stack: StackedPallet,
    station: PalletStation,
    played: PlayedPallet,
    record: Mapping[str, Any],
    replace: bool = True,
    with_plans: bool = False,
) -> tuple[Path, ...]:
    """Write all files of a trial, none of which is in the folder before all are written.

    Args:
        folder: The folder, created if it does not exist.
        stack: The stack that was played.
        station: The cell.
        played: The played trial.
        record: Its record, as JSON values.
        replace: Whether existing files may be replaced.
        with_plans: Whether to write every executed plan, and the scene that it was certified for.

    Returns:
        Paths of the files.

    Raises:
        InputError: A file cannot be written; all others are, and the message lists both.
    """
    cartons = [carton_item(placement.carton) for placement in stack.placements]
    comment = "Cartons of a pallet, as the cup takes them: for --items."
    motion = motion_values(played.recorder, [station.cell]) | {"record": record_digest(record)}
    writers: dict[str, Callable[[Path], None]] = {
        STACK: partial(write_stacked_pallet, stack=stack),
        ITEMS: partial(write_text, text=items_text(cartons, comment)),
        AFTER: partial(write_scene, played.after),
        MOTION: partial(write_motion, values=motion),
    }
    if with_plans:
        writers |= dict(plan_writers(played.plans))
    writers[RECORD] = partial(write_record, record=record)
    return write_files(folder, writers, replace)
