"""Writes the folder of a trial of a stream, and reads its motion. See docs/formats/trial.md."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace as replaced
from functools import partial
from pathlib import Path
from typing import Any

from pickcli.cell.cell import Cell
from pickcli.errors import InputError
from pickcli.files.atomic_write import write_bytes
from pickcli.motion.plan_file import write_plan
from pickcli.scene.stream_file import write_stream
from pickcli.stream_trials.pick_queries import StreamPlan
from pickcli.stream_trials.stream_trial import PlayedStream
from pickcli.trial.motion_record import RecordedMotion, motion_values, read_motion_of, write_motion
from pickcli.trial.trial_folder import MOTION, RECORD, write_files
from pickcli.trial.trial_record import record_digest, write_record

STREAM = "stream.json"
NAMES = (STREAM, MOTION, RECORD)


def write_stream_folder(
    folder: Path,
    stream_text: bytes,
    cells: tuple[Cell, ...],
    played: PlayedStream,
    record: Mapping[str, Any],
    replace: bool = True,
    with_plans: bool = False,
) -> tuple[Path, ...]:
    """Write all files of a trial, none of which is in the folder before all are written.

    Args:
        folder: The folder, created if it does not exist.
        stream_text: Content of the file of the stream, as it was read.
        cells: The cell as seen by each arm.
        played: The played trial.
        record: Its record, as JSON values.
        replace: Whether existing files may be replaced.
        with_plans: Whether to write every executed plan, and the stream as it was perceived then.

    Returns:
        Paths of the files.

    Raises:
        InputError: A file cannot be written; all others are, and the message lists both.
    """
    writers: dict[str, Callable[[Path], None]] = {STREAM: partial(write_bytes, content=stream_text)}
    if played.plans:
        motion = motion_values(played.recorder, cells) | {"record": record_digest(record)}
        writers[MOTION] = partial(write_motion, values=motion)
    if with_plans:
        writers |= dict(_plan_writers(played.plans))
    writers[RECORD] = partial(write_record, record=record)
    return write_files(folder, writers, replace)


def _plan_writers(plans: Sequence[StreamPlan]) -> Iterator[tuple[str, Callable[[Path], None]]]:
    """Yield the files of executed plans, without wall times, and of the streams as perceived then."""
    for k, each in enumerate(plans, start=1):
        yield f"plan_{k:03}.json", partial(write_plan, replaced(each.plan, statistics={}))
        yield f"seen_{k:03}.json", partial(write_stream, each.seen)


def read_stream_motion(folder: Path, record: Mapping[str, Any]) -> RecordedMotion:
    """Read what arms and items did in a trial.

    Args:
        folder: Folder of the trial.
        record: Its record.

    Returns:
        The motion.

    Raises:
        InputError: There is no such file as no arm moved; or it cannot be read, or has mistakes.
        StaleError: It is of another trial.
    """
    if not record["attempted"] and not (folder / MOTION).exists():
        raise InputError(f"{folder}: no arm moved in this trial, so there is nothing to replay")
    return read_motion_of(folder / MOTION, record)
