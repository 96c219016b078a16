"""Text output of ``apc inspect``: values in words, shortened to a screen."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from pickcli.commands.output.stored_motion import motion_text

MOST_LISTED = 3  # entries of a list that are shown without --all


def in_words(summary: dict[str, Any]) -> dict[str, Any]:
    """Replace values of a summary that only programs need one by one with sentences.

    Args:
        summary: Summary of a stored file, plan, scene, cell or stored motion, as ``--json`` prints it.

    Returns:
        The summary, with texts instead of values; of supports only those that are items.
    """
    if "segments" in summary:
        return _plan_in_words(summary)
    if "motions" in summary and "start" in summary:
        return {**summary, "motions": {load: motion_text(m) for load, m in summary["motions"].items()}}
    if "spheres" in summary:
        return {**summary, "spheres": _spheres_in_words(summary["spheres"])}
    if "camera_pose" in summary:
        return _perceived_in_words(summary)
    if "supports" not in summary:
        return summary
    lines = []
    for name, support in summary["supports"].items():
        others = [other for other in support["rests_on"] if other in summary["supports"]]
        parts = {"rests on": others, "without it fall": support["without_it_fall"]}
        parts["without it may roll"] = support["without_it_may_roll"]
        phrases = [f"{what} {', '.join(names)}" for what, names in parts.items() if names]
        lines += [f"{name}: {'; '.join(phrases)}"] if phrases else []
    return {**summary, "supports": lines or ["no item rests on another item"]}


def _perceived_in_words(summary: dict[str, Any]) -> dict[str, Any]:
    """Tell the answers of each place in a line each."""
    from pickcli.perception.items.confidence import truncated

    places = {}
    for place in summary["places"]:
        lines = [f"{place['seen']:.0%} of its room is seen"]
        for item in place["items"]:
            at = "" if item["pose"] is None else " ".join(f"{v:.3f}" for v in item["pose"]["position"])
            told = item["refusal"] or f"at {at}, confidence {truncated(item['confidence'])}"
            by_print = ", by its print" if item["found_by"] == "print" else ""
            lines.append(f"{item['id']}: {told}{by_print}")
        if place["unexplained"]:
            lines.append(f"parts that no answer explains: {len(place['unexplained'])}")
        places[place["place"]] = lines
    return {**summary, "places": places}


def _spheres_in_words(spheres: dict[str, dict[str, Any]]) -> dict[str, str]:
    """Format the spheres of each link in a line."""
    return {
        link: f"{each['count']}, {1e3 * each['mean_excess_m']:.1f} mm outside on average, "
        f"{1e3 * each['max_excess_m']:.1f} mm at most"
        for link, each in spheres.items()
    }


def on_a_screen(summary: dict[str, Any]) -> dict[str, Any]:
    """Shorten the summary of a stored file to a screen: values side by side, the first entries of every list.

    Args:
        summary: Summary from ``in_words``.

    Returns:
        The summary, shortened if it is of a roadmap or database.
    """
    if "made" not in summary:
        return summary
    head = f"{summary['format']}, version {summary['version']}, {summary['bytes']} bytes"
    brief: dict[str, Any] = {"format": head, "cell_fingerprint": summary["cell_fingerprint"]}
    brief["made"] = _provenance_lines(summary["made"])
    for key, value in summary.items():
        if key not in (*brief, "version", "bytes", "rows"):
            brief[key] = _shortened(value)
    return brief


def _shortened(value: Any) -> Any:
    """Format nonzero values side by side, or the first entries of a list; return others unchanged."""
    if isinstance(value, dict):
        return ", ".join(f"{name}: {figure}" for name, figure in value.items() if figure) or "none"
    if isinstance(value, list) and len(value) > MOST_LISTED:
        return [*value[:MOST_LISTED], f"and {len(value) - MOST_LISTED} more; --all lists them"]
    return value


def _provenance_lines(made: Mapping[str, Any]) -> list[str]:
    """Format versions and settings of a stored file, each in a line."""
    lines = []
    for key in ("by", "settings"):
        values = made.get(key)
        if isinstance(values, dict):
            lines.append(", ".join(f"{name} {value}" for name, value in values.items()))
    return lines


def _plan_in_words(summary: dict[str, Any]) -> dict[str, Any]:
    """Format a plan's segments, events, grasp and certificate in a sentence each."""
    grasp = summary["grasp"]
    is_certified = summary["certified"]
    segments = [
        f"{s['t_start_s']:.3f}..{s['t_end_s']:.3f} s {s['kind']}, tool {s['tool_state']}"
        for s in summary["segments"]
    ]
    events = sorted(summary["events"], key=lambda e: math.inf if e["t_s"] is None else e["t_s"])
    return {
        **summary,
        "certified": "its seal matches the plan; apc verify checks whether it is true"
        if is_certified
        else "no",
        "grasp": None if grasp is None else f"{grasp['kind']} on {grasp['item']}, face {grasp['face']}",
        "segments": segments,
        "events": [_event(e["t_s"], e["device"], e["action"]) for e in events],
    }


def _event(t_trigger: float | None, device: str, action: str) -> str:
    return f"{device} {action} " + ("not resolved" if t_trigger is None else f"at {t_trigger:.3f} s")
