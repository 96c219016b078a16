"""Output of commands on stdout: JSON values for programs, short text for people."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pickcli.commands.output.table import FILE_WIDTH
from pickcli.errors import printable

if TYPE_CHECKING:
    from pickcli.motion.plan import Plan

KEY_WIDTH = 18  # characters of the widest key
LEAST_ROOM = 30  # least columns for a value beside its key; with fewer, it is printed below
INDENT = "    "  # of a value below its key
DIGEST = re.compile(r"\b[0-9a-f]{64}\b")  # SHA-256: copied as one word or not at all


def key_lines(summary: Mapping[str, Any], width: int | None = None) -> list[str]:
    """Format ``key: value`` lines; long or nested values continue below their key.

    Args:
        summary: Values by key.
        width: Columns of a line; longer words are folded, unless they are hashes. None if unknown: then words
            are kept whole, for programs that search for them.

    Returns:
        The lines.
    """
    return [
        line
        for key, value in summary.items()
        for line in _below(f"{printable(key):>{KEY_WIDTH}}", value, width or FILE_WIDTH, width is not None)
    ]


def _below(key: str, value: Any, width: int, is_folded: bool) -> list[str]:
    """Format a value, the first line beside its key if there is room, the others below that."""
    room = width - len(key) - 2
    first, *rest = _entries(value, max(room, 1), is_folded)
    is_beyond = len(first) > room and (is_folded or room < LEAST_ROOM)
    if is_beyond or (room < LEAST_ROOM and rest):
        below = _entries(value, max(width - len(INDENT), 1), is_folded)
        return [f"{key}:", *(f"{INDENT}{line}" for line in below)]
    return [f"{key}: {first}", *(f"{'':>{len(key)}}  {line}" for line in rest)]


def _entries(value: Any, width: int, is_folded: bool) -> list[str]:
    """Format one value in at least one line."""
    if isinstance(value, dict):
        lines = [line for key, v in value.items() for line in _below(printable(key), v, width, is_folded)]
        return lines or ["none"]
    if isinstance(value, list):
        texts = [_in_words(v) for v in value]
        if not any(" " in text for text in texts):  # words are printed side by side, phrases below each other
            texts = [" ".join(texts)] if texts else ["none"]
        return [line for text in texts for line in _wrapped(text, width, is_folded)]
    return _wrapped(_in_words(value), width, is_folded)


def _in_words(value: Any) -> str:
    """Format one value without structure, or the values of a list side by side."""
    if value is None:
        return "none"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, list):
        return " ".join(map(_in_words, value))
    return printable(str(value))


def _wrapped(text: str, width: int, is_folded: bool) -> list[str]:
    """Wrap a text to a number of columns; a line with a word that may not be folded can be longer."""
    is_cut = is_folded and DIGEST.search(text) is None
    return textwrap.wrap(text, width, break_long_words=is_cut, break_on_hyphens=False) or [text]


def plan_summary(plan: Plan, path: Path) -> dict[str, Any]:
    """Summarise a plan that was written or read.

    Args:
        plan: The plan.
        path: Its file.

    Returns:
        JSON values by name.
    """
    grasp, certificate = plan.grasp, plan.certificate
    return {
        "path": str(path),
        "query": plan.query,
        **_arms(plan),
        "duration_s": plan.trajectory.duration,
        "speed_scale": plan.speed_scale,
        "certified": certificate is not None,
        "min_clearance_m": None if certificate is None else certificate.min_clearance,
        "grasp": None
        if grasp is None
        else {
            "item": grasp.item,
            "kind": grasp.kind,
            "face": grasp.face,
            "tool_state": str(grasp.tool_state),
        },
        "segments": [
            {
                "kind": str(s.kind),
                "t_start_s": s.t_start,
                "t_end_s": s.t_end,
                "tool_state": str(s.tool_state),
                "held": s.held,
            }
            for s in plan.segments
        ],
        "events": [{"device": e.device, "action": e.action, "t_s": e.t_trigger} for e in plan.events],
        "statistics": plan.statistics,
    }


def _arms(plan: Plan) -> dict[str, Any]:
    """Return the moving arm and the states of the others; {} in a cell with one arm."""
    if not plan.arm:
        return {}
    others = {
        state.arm: {"q": state.q.tolist(), "tool_state": str(state.tool_state)} for state in plan.others
    }
    return {"arm": plan.arm, "others": others}


def plan_text(plan: Plan, path: Path) -> str:
    """Summarise a plan as text: its grasp, a timetable, and its file.

    Args:
        plan: The plan.
        path: Its file.

    Returns:
        The text.
    """
    grasp, certificate = plan.grasp, plan.certificate
    trust = (
        "not certified: it is verified before it is executed or exported"
        if certificate is None
        else f"certified, at least {certificate.clearance_mm:.1f} mm clear except at planned contacts"
    )
    slow = "" if plan.speed_scale == 1.0 else f", item carried at {plan.speed_scale:.2f} of full speed"
    how = f"{grasp.kind} grasp on face {grasp.face} of {grasp.item}" if grasp else _tool(plan)
    if grasp and grasp.envelope:
        how += f", found in envelope {grasp.envelope}"
    if plan.arm:
        how += "".join(
            [
                f"; arm {plan.arm}",
                *(f"\n  meanwhile arm {state.arm} stands at {state}" for state in plan.others),
            ]
        )
    wall = {name: ms for name, ms in plan.statistics.items() if name.endswith("_ms")}
    times = ", ".join(f"{name.removesuffix('_ms')} {ms:.0f} ms" for name, ms in wall.items())
    return "\n".join(
        [f"{plan.query}: {plan.trajectory.duration:.2f} s{slow}", f"  {how}", f"  {trust}", *_timetable(plan),
         *_searched(plan), f"  took: {times}", f"  wrote {path}"]
    )  # fmt: skip


def _tool(plan: Plan) -> str:
    """Describe the sequence of states of the empty tool."""
    states = [str(segment.tool_state) for segment in plan.segments]
    return (
        f"tool {', then '.join(state for i, state in enumerate(states) if i == 0 or state != states[i - 1])}"
    )


def _searched(plan: Plan) -> list[str]:
    """Format what a search with a bound knows of the transit, if one planned it."""
    found = plan.statistics
    if "transit_cost_bound" not in found:
        return []
    expansions, bound = f"{found['transit_expansions']:.0f} expansions", found["transit_cost_bound"]
    proven = (
        f"the least on the lattice, as {expansions} prove"
        if bound == 1.0
        else f"at most {bound:.3f} times the least on the lattice, as {expansions} prove; then they ran out"
    )
    return [f"  transit by ARA*: costs {found['transit_cost_m']:.3f} m, {proven}"]


def _timetable(plan: Plan) -> list[str]:
    """Format segments and events in the order of time."""
    rows = [(s.t_start, f"{s.kind}, {s.t_end - s.t_start:.2f} s") for s in plan.segments]
    rows += [(e.t_trigger, f"  {e.device} {e.action}") for e in plan.events if e.t_trigger is not None]
    return [f"  {t:7.3f} s  {what}" for t, what in sorted(rows, key=lambda row: row[0])]
