"""Writes the folder of a trial of a commission. Its files are described in docs/formats/trial.md."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

from pickcli.cell.schemas.items_text import items_text
from pickcli.commission.commission_station import CommissionStation
from pickcli.commission.commission_trial import PlayedCommission
from pickcli.errors import StaleError
from pickcli.files.atomic_write import write_text
from pickcli.scene.scene import Scene
from pickcli.scene.scene_file import read_scene, scene_hash, write_scene
from pickcli.trial.motion_record import (
    RecordedMotion,
    motion_values,
    read_motion_of,
    refuse_other_motion,
    write_motion,
)
from pickcli.trial.scene_plan import plan_writers
from pickcli.trial.trial_folder import MOTION, RECORD, write_files
from pickcli.trial.trial_record import record_digest, write_record

COMMISSION, ITEMS, SCENE = "commission.yaml", "items.yaml", "scene.json"
NAMES = (COMMISSION, ITEMS, SCENE, MOTION, RECORD)


def write_commission_folder(
    folder: Path,
    text: str,
    station: CommissionStation,
    played: PlayedCommission,
    record: Mapping[str, Any],
    replace: bool = True,
    with_plans: bool = False,
) -> tuple[Path, ...]:
    """Write all files of a trial, none of which is in the folder before all are written.

    Args:
        folder: The folder, created if it does not exist.
        text: The file of the commission, as it was read.
        station: The commission in its cell.
        played: The played trial. Scene and motion are written only if the truck came to the load.
        record: Its record, as JSON values.
        replace: Whether existing files may be replaced.
        with_plans: Whether to write every executed plan, and the scene that it was certified for.

    Returns:
        Paths of the files.

    Raises:
        InputError: A file cannot be written; all others are, and the message lists both.
    """
    products = {each.item.name: each.item for each in station.commission.items}
    comment = "Products of a commission, as fingers take them: for --items."
    writers: dict[str, Callable[[Path], None]] = {
        COMMISSION: partial(write_text, text=text),
        ITEMS: partial(write_text, text=items_text(list(products.values()), comment)),
    }
    if played.before is not None:
        motion = motion_values(played.recorder, [station.cell]) | {"record": record_digest(record)}
        writers[SCENE] = partial(write_scene, played.before)
        writers[MOTION] = partial(write_motion, values=motion)
    if with_plans:
        writers |= dict(plan_writers(played.plans))
    writers[RECORD] = partial(write_record, record=record)
    return write_files(folder, writers, replace)


def read_commission_motion(
    folder: Path, record: Mapping[str, Any], station: CommissionStation
) -> tuple[Scene | None, RecordedMotion | None]:
    """Read what arm and items did in a trial.

    Args:
        folder: Folder of the trial.
        record: Its record.
        station: The commission in its cell.

    Returns:
        The true scene as the truck came to the load, and the motion from there on; None each if it did not.

    Raises:
        InputError: A file cannot be read, or has mistakes.
        StaleError: They are of another trial.
    """
    if not (folder / SCENE).exists():
        return None, None
    motion, scene = read_motion_of(folder / MOTION, record), read_scene(folder / SCENE, station.cell)
    if scene_hash(scene) != record["made_from"].get("scene_hash"):
        raise StaleError(f"{folder / SCENE}: is not the scene of {folder / RECORD}; play the trial again")
    refuse_other_motion(motion, scene, (station.cell,), str(folder / MOTION))
    return scene, motion
