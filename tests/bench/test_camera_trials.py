"""Trials by camera beside those by noise: what is lost, and which bounds were kept."""

from __future__ import annotations

from typing import Any

import pytest

from bench.camera_trials import Comparison, is_kept, row


def seen(off: float | None, bound: float | None = 2.0) -> dict[str, Any]:
    return {
        "place": "bin_A", "item": "soap",
        "bound_mm": bound, "bound_deg": bound, "bound_surface_mm": bound,
        "truly_off_mm": off, "truly_off_deg": off, "truly_off_surface_mm": off,
    }  # fmt: skip


def record(score: int, *points: int, looks: list[dict[str, Any]] | None = None) -> dict[str, Any]:
    items = [
        {"bin": f"bin_{k}", "item": f"item_{k}", "points": each, "outcome": "no plan", "reason": "hidden"}
        for k, each in enumerate(points)
    ]
    return {"score": score, "max_score": 40, "items": items, "collisions": 0, "looks": looks or []}


@pytest.mark.parametrize(("off", "is_within"), [(1.9, True), (2.0, True), (2.1, False), (None, False)])
def test_a_bound_is_kept_if_all_errors_are_within(off: float | None, is_within: bool) -> None:
    assert is_kept(seen(off)) is is_within
    if off is not None:
        assert not is_kept(seen(1.0) | {"truly_off_surface_mm": 2.1})


def test_what_is_compared_is_what_was_played() -> None:
    looks = [{"items": [seen(1.0), seen(3.0), seen(3.0, None)]}, {"items": [seen(0.5)]}]
    compared = Comparison(7, record(30, 10, 20, 0), record(20, 0, 20, 0, looks=looks))
    assert compared.bounds == (3, 1)
    told = "bin_A soap is off by 3.0, 3.0, 3.0, stated 2.0, 2.0, 2.0"
    assert compared.broken == [told]
    assert compared.lost == ["bin_0 item_0 (10): no plan, hidden"]
    assert row("all", [compared, compared]) == "| all | 60 of 80 | 40 | 67% | 6, 2 | 0, 0 |"
