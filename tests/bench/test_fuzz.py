"""The fuzzer: it sees what a case does to its process, and a few hundred cases do nothing to theirs."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from bench.fuzz.mutate import mutated_bytes, mutated_value
from bench.fuzz.sandbox import FAILURES, Limits, Outcome, tried
from bench.fuzz.targets import Kind, kinds, sound
from pickcli.errors import InputError, WorkerLostError

SMALL = Limits(seconds=1.0, megabytes=100)


def _refuse() -> None:
    raise InputError("not this one")


def _blame_ourselves() -> None:
    raise WorkerLostError("an exit code of a bug")


def _take_memory() -> None:
    held = [np.ones(2**20) for _ in range(100)]
    del held


def _run_on() -> None:
    while True:
        pass


def _stumble() -> None:
    raise KeyError("missing")


ATTEMPTS: dict[Outcome, Callable[[], object]] = {
    Outcome.ACCEPTED: lambda: None,
    Outcome.REFUSED: _refuse,
    Outcome.TRACEBACK: _stumble,
    Outcome.MEMORY: _take_memory,
    Outcome.HANG: _run_on,
    Outcome.CRASH: lambda: os.kill(os.getpid(), signal.SIGSEGV),
}


@pytest.mark.parametrize("outcome", ATTEMPTS)
def test_what_becomes_of_a_case_is_seen_and_the_next_is_tried(outcome: Outcome) -> None:
    def attempt(case: int) -> None:
        if case == 1:
            ATTEMPTS[outcome]()

    results = list(tried(attempt, range(3), SMALL))
    assert [result.case for result in results] == [0, 1, 2]
    assert [result.outcome for result in results] == [Outcome.ACCEPTED, outcome, Outcome.ACCEPTED]


def test_our_own_errors_with_the_exit_code_of_a_bug_are_no_refusal() -> None:
    (result,) = tried(lambda case: _blame_ourselves(), range(1), SMALL)
    assert result.outcome is Outcome.TRACEBACK and "WorkerLostError" in result.where


def test_the_same_seed_breaks_the_same_things() -> None:
    value, content = {"a": [1, 2, {"b": "text"}], "c": 0.5}, b"a: [1, 2, {b: text}]\n"
    for seed in range(20):
        one, other = np.random.default_rng(seed), np.random.default_rng(seed)
        assert repr(mutated_value(value, one)) == repr(mutated_value(value, other))
        assert mutated_bytes(content, one) == mutated_bytes(content, other)
    assert value == {"a": [1, 2, {"b": "text"}], "c": 0.5}


@pytest.fixture(scope="module")
def all_kinds(tmp_path_factory: pytest.TempPathFactory) -> tuple[Kind, ...]:
    return kinds(sound(), tmp_path_factory.mktemp("fuzz"), 7)


@pytest.mark.slow
def test_a_few_of_each_kind_are_accepted_or_refused(all_kinds: tuple[Kind, ...]) -> None:
    assert sum(kind.share for kind in all_kinds) == pytest.approx(1.0)
    for kind in all_kinds:
        results = list(tried(kind.attempt, range(30), Limits()))
        assert [result for result in results if result.outcome in FAILURES] == [], kind.name


@pytest.mark.slow
def test_an_unbroken_input_is_accepted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Otherwise all would be refused for one and the same reason, and nothing be learned."""
    monkeypatch.setattr("bench.fuzz.targets.mutated_bytes", lambda content, rng: content)
    monkeypatch.setattr("bench.fuzz.targets.mutated_value", lambda value, rng: value)
    monkeypatch.setattr("bench.fuzz.targets._extreme", lambda plan, rng: plan)
    all_kinds = kinds(sound(), tmp_path, 1)
    assert all_kinds
    for kind in all_kinds:
        results = list(tried(kind.attempt, range(4), Limits()))
        assert {result.outcome for result in results} == {Outcome.ACCEPTED}, (kind.name, results)
