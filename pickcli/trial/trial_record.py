"""Record of a trial as JSON, with all measurements. The format is described in docs/formats/trial.md.

All wall-clock figures are under ``statistics``: without that key, two runs of a trial with the same seed give
identical bytes.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from pickcli.cell.pod_tolerance import yaw_of
from pickcli.errors import Reason
from pickcli.files.atomic_write import write_text
from pickcli.motion.plan import Plan
from pickcli.package_versions import package_versions
from pickcli.perception.perception_versions import print_versions
from pickcli.scene.scene import TOTE, PoseNoise, Scene
from pickcli.scene.scene_file import scene_hash
from pickcli.strategy.tree_player import Tick
from pickcli.trial.disturbance import Disturbance
from pickcli.trial.record_kind import PACKAGES, RecordKind
from pickcli.trial.record_schema import refuse_bad_record
from pickcli.trial.tote_shift import ToteTouches, tote_displacement
from pickcli.trial.trial_interfaces import ExecutionResult
from pickcli.trial.trial_perception import LookRecord, PerceivedItem
from pickcli.trial.trial_result import Attempt, RecoveryStep, TargetResult, TrialResult

RECORDS = RecordKind("a trial", "apc-trial", 2, check=refuse_bad_record)
CLAIM = (
    "Planning and verification saw the true poses with an error within pose_noise, but for a share of the "
    "poses, pose_outlier_share, that was off by up to pose_outlier_scale times as much; by camera they saw "
    "bins in pictures, with errors as listed under looks. For the poses that they saw, and all within the "
    "bounds of the error, every executed motion was certified "
    "beforehand: in this model it keeps the clearance and limits that its certificate states. This is "
    "evidence about the model, not a statement about the safety of a cell."
)
MOST_REASONS = 20  # largest number per attempt
_FIGURE = re.compile(r"\d+(?:\.\d+)?")


def trial_record(result: TrialResult, order_file: str, wall_s: float) -> dict[str, Any]:
    """Convert a trial to JSON data, with the main figures first.

    Args:
        result: The result of the trial.
        order_file: Name of the order.
        wall_s: Wall time of the trial, s.

    Returns:
        JSON values by name.
    """
    return {
        "score": result.score.total,
        "max_score": result.score.maximum,
        "items_in_tote": result.items_in_tote,
        "misjudged": result.n_misjudged,
        "items": [_target(target) for target in result.targets],
        "collisions": result.n_collisions,
        "limit_violations": result.n_limit_violations,
        "drops": len(result.drops),
        "disturbed": len({d.item for d in result.disturbed}),
        "damages": [[what, str(damage)] for what, damage in result.final.damages],
        "simulated_s": _rounded(result.simulated),
        "clock_s": _rounded(result.clock),
        "aborted": result.aborted,
        "cut_short": result.cut_short,
        "pose_noise": {
            "position_mm": _rounded(1e3 * result.noise.position),
            "angle_deg": _rounded(np.degrees(result.noise.angle)),
        },
        "perception": str(result.perception),
        "sift": str(result.sift),
        "pod_shift": _pod_shift(result.before),
        **_tote(result),
        "reality": result.reality.as_dict(),
        "score_lines": [dataclasses.asdict(line) for line in result.score.lines],
        "final_places": {item.id: item.end for item in result.final.items},
        "contacts": [dataclasses.asdict(collision) for collision in result.collisions],
        "attempts": [_attempt(attempt) for attempt in result.attempts],
        "strategy": {"name": result.strategy, "hash": result.strategy_hash, "stuck": result.strategy_stuck},
        "ticks": [_tick(tick) for tick in result.ticks],
        **({"looks": [_look(look) for look in result.looks]} if result.looks else {}),
        "disturbed_last": [_disturbance(d) for d in result.disturbed_last],
        **_arms(result),
        "claim": CLAIM,
        "made_from": _made_from(result, order_file),
        "statistics": _statistics(result, wall_s),
    }


def _look(look: LookRecord) -> dict[str, Any]:
    return {
        "number": look.number,
        "cameras": {place: list(of) for place, of in look.cameras.items()},
        "items": [_seen(seen) for seen in look.items],
        "motions": len(look.motions),
        "motion_s": _rounded(sum(execution.duration for execution in look.motions)),
    }


def _seen(seen: PerceivedItem) -> dict[str, Any]:
    answer, bound = seen.answer, seen.bound
    return {
        "place": seen.place,
        "item": answer.id,
        "confidence": _rounded(answer.confidence),
        "refusal": answer.refusal,
        "found_by": answer.found_by.value,
        "bound_mm": None if bound is None else _rounded(1e3 * bound.position),
        "bound_deg": None if bound is None else _rounded(np.degrees(bound.angle)),
        "bound_surface_mm": _in_mm(bound),
        "truly_off_mm": None if seen.off is None else _rounded(1e3 * seen.off.position),
        "truly_off_deg": None if seen.off is None else _rounded(np.degrees(seen.off.angle)),
        "truly_off_surface_mm": _in_mm(seen.off),
    }


def _in_mm(error: PoseNoise | None) -> float | None:
    """The displacement of the surface in mm."""
    return None if error is None or error.displacement is None else _rounded(1e3 * error.displacement)


def record_text(record: Mapping[str, Any]) -> str:
    """Format the record as JSON text.

    Args:
        record: JSON values by name.

    Returns:
        The text.
    """
    return json.dumps(record, indent=2, allow_nan=False) + "\n"


def record_digest(record: Mapping[str, Any]) -> str:
    """Compute what tells a trial from others, and its record from one that was changed.

    Args:
        record: JSON values of the record.

    Returns:
        SHA-256 of all but the figures of the wall clock.
    """
    told = {key: value for key, value in record.items() if key != "statistics"}
    return hashlib.sha256(json.dumps(told, sort_keys=True).encode()).hexdigest()


def write_record(path: Path, record: Mapping[str, Any], replace: bool = True) -> None:
    """Write the record to a file.

    Args:
        path: The file.
        record: JSON values by name.
        replace: Whether an existing file may be replaced.

    Raises:
        InputError: The file cannot be written.
    """
    write_text(path, record_text(record), replace)


def read_record(path: Path) -> dict[str, Any]:
    """Read the record of a trial.

    Args:
        path: The file.

    Returns:
        JSON values by name.

    Raises:
        InputError: The file cannot be read, is no record, or lacks required fields: with every field.
        StaleError: It has another version of the format.
    """
    return RECORDS.read(path)


def _made_from(result: TrialResult, order_file: str) -> dict[str, Any]:
    routes = (seen.answer.route for look in result.looks for seen in look.items)
    return {
        "format": RECORDS.format,
        "version": RECORDS.version,
        "order": order_file,
        "seed": result.seed,
        "cell": result.before.cell.name,
        "cell_fingerprint": result.before.cell.scene_fingerprint,
        "scene_hash": scene_hash(result.before),
        "versions": {**package_versions(PACKAGES), **print_versions(routes)},
    }


def _arms(result: TrialResult) -> dict[str, Any]:
    """Summary of each arm; empty with a single arm."""
    return (
        {"arms": {arm: dataclasses.asdict(work) for arm, work in result.arms.items()}} if result.arms else {}
    )


def _tick(tick: Tick) -> dict[str, Any]:
    outcome = "success" if tick.is_success else "failure"
    return {"t": _rounded(tick.t), "node": tick.node, "target": tick.target, "status": outcome}


def _pod_shift(scene: Scene) -> dict[str, float]:
    """Displacement of the true pod from its nominal pose."""
    x, y = (_rounded(1e3 * v) for v in scene.T_nominal_pod[:2, 3])
    return {"x_mm": x, "y_mm": y, "yaw_deg": _rounded(np.degrees(yaw_of(scene.T_nominal_pod)))}


def _tote(result: TrialResult) -> dict[str, Any]:
    """Displacement of the true tote, and what touches told of it; empty for one at its place, untouched."""
    true, touches = result.before, result.tote
    told: dict[str, Any] = {}
    if TOTE in true.carriers:
        told["tote_shift"] = _tote_in_mm(tote_displacement(true))
    if touches is not None:
        told["tote_touches"] = {
            "reason": touches.reason,
            "duration_s": _rounded(touches.duration),
            "planning_calls": touches.n_planned,
            **_located_tote(touches, true),
        }
    return told


def _located_tote(touches: ToteTouches, true: Scene) -> dict[str, Any]:
    """The estimate of a located tote, with the truth beside it."""
    located = touches.located
    if located is None:
        return {}
    estimate, off = located.estimate, touches.off(true)
    return {
        "bound": _tote_in_mm(dict(zip(estimate.names, estimate.bounds.tolist(), strict=True))),
        "truly_off": _tote_in_mm(off),
        "touches": [
            {"name": each.touched.aim.name, "force": _rounded(each.record.most_force)}
            for each in located.touches
        ],
    }


def _tote_in_mm(offset: Mapping[str, float]) -> dict[str, float]:
    """Offsets of a tote by name, in mm and degrees."""
    return {
        f"{name}_deg" if name == "yaw" else f"{name}_mm": _rounded(
            np.degrees(value) if name == "yaw" else 1e3 * value
        )
        for name, value in offset.items()
    }


def _target(target: TargetResult) -> dict[str, Any]:
    return {
        "bin": target.target.bin,
        "item": target.target.item,
        "outcome": str(target.outcome),
        "reason": target.reason,
        "points": target.points,
        "attempts": len(target.attempts),
        "motion_s": _rounded(sum(e.duration for a in target.attempts for e in a.executions)),
    }


def _attempt(attempt: Attempt) -> dict[str, Any]:
    return {
        "bin": attempt.target.bin,
        "item": attempt.item or attempt.target.item,
        "out_of": attempt.out_of,
        "into": attempt.into,
        "is_aside": attempt.is_aside,
        "topples": attempt.topples,
        "number": attempt.number,
        "outcome": str(attempt.outcome),
        "reason": attempt.reason,
        "reasons": _reasons(attempt.reasons),
        "rejected": [_reasons(plan.reasons) for plan in attempt.rejected],
        **_turn(attempt),
        "t_start": _rounded(attempt.t_start),
        "plan": None if attempt.plan is None else _plan(attempt.plan),
        "execution": None if attempt.execution is None else _execution(attempt.execution),
        "recovery": [_step(step) for step in attempt.recovery],
        "seen_in": attempt.seen_in,
        "truly_in": attempt.truly_in,
    }


def _reasons(reasons: Iterable[Reason]) -> list[dict[str, Any]]:
    """Merge reasons that differ only in figures, keeping the first; the most frequent come first."""
    groups: dict[tuple[str, ...], list[Reason]] = {}
    for reason in reasons:
        key = (reason.what, reason.where, _FIGURE.sub("", reason.detail), reason.in_the_way)
        groups.setdefault(key, []).append(reason)
    ranked = sorted(groups.values(), key=lambda group: -len(group))[:MOST_REASONS]
    return [{**dataclasses.asdict(group[0]), "count": len(group)} for group in ranked]


def _turn(attempt: Attempt) -> dict[str, Any]:
    """The chosen arm with the ranking; empty with a single arm."""
    if not attempt.arms:
        return {}
    ranked = [
        {**dataclasses.asdict(arm), "against": arm.against and str(arm.against)} for arm in attempt.arms
    ]
    return {
        "arm": "" if attempt.plan is None else attempt.plan.arm,
        "arms_ranked": ranked,
        "parking": None if attempt.parking is None else _execution(attempt.parking),
    }


def _step(step: RecoveryStep) -> dict[str, Any]:
    execution = None if step.execution is None else _execution(step.execution)
    return {"what": step.what, "reason": step.reason, "execution": execution}


def _plan(plan: Plan) -> dict[str, Any]:
    grasp, certificate = plan.grasp, plan.certificate
    return {
        "query": plan.query,
        "seed": plan.seed,
        "duration": _rounded(plan.trajectory.duration),
        "grasp": None
        if grasp is None
        else {
            "kind": grasp.kind,
            "face": grasp.face,
            "tool_state": str(grasp.tool_state),
            "load_ratio": _rounded(grasp.load_ratio),
            **({"envelope": grasp.envelope} if grasp.envelope else {}),
        },
        "segments": [[str(s.kind), _rounded(s.t_start), _rounded(s.t_end)] for s in plan.segments],
        "pushing": sorted({name for segment in plan.segments for name in segment.pushing}),
        "certificate": None if certificate is None else dataclasses.asdict(certificate),
    }


def _execution(execution: ExecutionResult) -> dict[str, Any]:
    return {
        "duration": _rounded(execution.duration),
        "stopped": execution.stopped,
        "stop_cause": None if execution.stop_cause is None else str(execution.stop_cause),
        "has_item": execution.has_item,
        "collisions": [dataclasses.asdict(collision) for collision in execution.collisions],
        "limit_violations": list(execution.limit_violations),
        "drops": [dataclasses.asdict(drop) for drop in execution.drops],
        "disturbed": [_disturbance(d) for d in execution.disturbed],
        "events": [dict(event) for event in execution.events],
        "missed_events": list(execution.missed),
        "max_lag": _rounded(execution.max_lag),
        "max_load": _rounded(execution.max_load),
        "operator_stops": [
            [_rounded(stop.begin), None if stop.end is None else _rounded(stop.end)]
            for stop in execution.operator_stops
        ],
    }


def _disturbance(d: Disturbance) -> dict[str, Any]:
    return {
        "item": d.item,
        "kind": str(d.kind),
        "moved": _rounded(d.moved),
        "turned": _rounded(d.turned),
        "fell": _rounded(d.fell),
        "out_of": d.out_of,
        "into": d.into,
    }


def _statistics(result: TrialResult, wall_s: float) -> dict[str, Any]:
    planning = [a.statistics["planning_ms"] for a in result.attempts if a.plan is not None]
    verifying = [
        a.statistics["verification_ms"] for a in result.attempts if "verification_ms" in a.statistics
    ]
    return {
        "wall_s": wall_s,
        "planning_ms": {"median": _median(planning), "max": max(planning, default=None)},
        "verification_ms": {"median": _median(verifying), "max": max(verifying, default=None)},
        "attempts": [dict(attempt.statistics) for attempt in result.attempts],
    }


def _median(values: list[float]) -> float | None:
    return float(np.median(values)) if values else None


def _rounded(value: float) -> float:
    """Round to a microsecond or micrometre, for readability."""
    return round(float(value), 6)
