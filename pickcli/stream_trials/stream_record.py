"""The record of a trial of a stream: what was played under which conditions, and what became of the items."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

from pickcli.cell.cell import Cell
from pickcli.planning.planning_context import PlanningContext
from pickcli.scene.item_stream import ItemStream
from pickcli.scene.stream_file import read_stream
from pickcli.stream_trials.stream_record_schema import refuse_bad_stream_record
from pickcli.stream_trials.stream_result import StreamTrialResult
from pickcli.stream_trials.stream_trial_request import StreamTrialRequest
from pickcli.trial.record_kind import RecordKind, refuse_other_file

COUNTS = "presented", "attempted", "delivered", "collisions", "limit_violations", "stops"
RECORDS = RecordKind("a stream", "apc-stream-trial", 3, check=refuse_bad_stream_record)


def stream_record(
    request: StreamTrialRequest,
    result: StreamTrialResult,
    context: PlanningContext,
    stream_name: str,
    stream_sha256: str,
) -> dict[str, Any]:
    """Return the record as JSON values; all but ``statistics`` is a function of stream, conditions and seed.

    Args:
        request: The stream and the conditions.
        result: The result.
        context: That of one of the arms.
        stream_name: Name of the file of the stream.
        stream_sha256: Digest of that file as it was read.

    Returns:
        Values by name.
    """
    camera = request.camera
    noise = {"noise": request.noise.figures, "speed_error_m_s": request.speed_error}
    return {
        **result.record(),
        **(noise if camera is None else {"camera": asdict(camera)}),
        "reality": request.reality.as_dict(),
        "rule": str(request.rule),
        **planned_by_values(context),
        "made_from": RECORDS.made_from(
            request.stream.cell, request.seed, stream=stream_name, stream_sha256=stream_sha256
        ),
    }


def planned_by_values(context: PlanningContext) -> dict[str, int | None]:
    """Return what plans the transits of a trial, and from which grasps, as JSON values.

    Args:
        context: That of one of the arms.

    Returns:
        The most expansions of a search of ARA*, None for the usual planners; and the number of recorded
        grasps, None where grasps come from elsewhere.
    """
    recorded = None if context.recorded is None else len(context.recorded)
    return {"expansions": context.settings.expansions, "recorded_grasps": recorded}


def read_played_stream(
    path: Path, record: dict[str, Any], load: Callable[[str], Cell], cell: Cell | None = None
) -> ItemStream:
    """Read the stream that a trial played.

    Args:
        path: File of the stream.
        record: Record of the trial.
        load: Opens the cell that the stream names.
        cell: Its cell, if it is stated; None for the one that the stream names.

    Returns:
        The stream.

    Raises:
        InputError: The file cannot be read, or has mistakes.
        StaleError: It is another file than the one of the record, or its cell has changed.
    """
    stream = read_stream(path, cell, load)
    refuse_other_file("stream", path, record)
    return stream
