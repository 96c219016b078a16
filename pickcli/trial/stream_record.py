"""The record of a trial of a stream: what was played under which conditions, and what became of the items."""

from __future__ import annotations

import hashlib
from dataclasses import asdict
from pathlib import Path
from typing import Any

from pickcli.trial.stream_result import StreamTrialResult
from pickcli.trial.stream_trial import StreamTrialRequest
from pickcli.trial.trial_record import package_versions

FORMAT = "apc stream trial"
VERSION = 1


def stream_record(
    request: StreamTrialRequest, result: StreamTrialResult, stream_file: Path
) -> dict[str, Any]:
    """Return the record as JSON values; all but ``statistics`` is a function of stream, conditions and seed.

    Args:
        request: The stream and the conditions.
        result: The result.
        stream_file: File of the stream.

    Returns:
        Values by name.
    """
    cell, camera = request.stream.cell, request.camera
    noise = {"noise": request.noise.figures, "speed_error_m_s": request.speed_error}
    return {
        **result.record(),
        **(noise if camera is None else {"camera": asdict(camera)}),
        "reality": request.reality.as_dict(),
        "made_from": {
            "format": FORMAT,
            "version": VERSION,
            "stream": stream_file.name,
            "stream_sha256": hashlib.sha256(stream_file.read_bytes()).hexdigest(),
            "seed": request.seed,
            "cell": cell.name,
            "cell_fingerprint": cell.scene_fingerprint,
            "versions": package_versions(),
        },
    }
