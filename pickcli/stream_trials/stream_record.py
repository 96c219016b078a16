"""The record of a trial of a stream: what was played under which conditions, and what became of the items."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from pickcli.stream_trials.stream_result import StreamTrialResult
from pickcli.stream_trials.stream_trial import StreamTrialRequest
from pickcli.trial.trial_record import package_versions

FORMAT = "apc stream trial"
VERSION = 1


def stream_record(
    request: StreamTrialRequest, result: StreamTrialResult, stream_name: str, stream_sha256: str
) -> dict[str, Any]:
    """Return the record as JSON values; all but ``statistics`` is a function of stream, conditions and seed.

    Args:
        request: The stream and the conditions.
        result: The result.
        stream_name: Name of the file of the stream.
        stream_sha256: Digest of that file as it was read.

    Returns:
        Values by name.
    """
    cell, camera = request.stream.cell, request.camera
    noise = {"noise": request.noise.figures, "speed_error_m_s": request.speed_error}
    return {
        **result.record(),
        **(noise if camera is None else {"camera": asdict(camera)}),
        "reality": request.reality.as_dict(),
        "rule": str(request.rule),
        "made_from": {
            "format": FORMAT,
            "version": VERSION,
            "stream": stream_name,
            "stream_sha256": stream_sha256,
            "seed": request.seed,
            "cell": cell.name,
            "cell_fingerprint": cell.scene_fingerprint,
            "versions": package_versions(),
        },
    }
