"""Cases tried in processes of their own, with bounded time and memory: what a case does to its process."""

from __future__ import annotations

import faulthandler
import os
import resource
import signal
import traceback
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from select import select

from pickcli.errors import ApcError

BATCH = 100  # cases that one process tries
WALL = 12.0  # times the limit of CPU time, after which a process counts as waiting for ever


class Outcome(StrEnum):
    """What became of a case."""

    ACCEPTED = "accepted"
    REFUSED = "refused"  # by one of our own errors, with an exit code of bad input
    TRACEBACK = "traceback"
    HANG = "hang"
    MEMORY = "memory"
    CRASH = "crash"


FAILURES = (Outcome.TRACEBACK, Outcome.HANG, Outcome.MEMORY, Outcome.CRASH)


@dataclass(frozen=True)
class Limits:
    """What one case may take.

    seconds: of CPU time
    megabytes: of memory of its process, over what that had before
    """

    seconds: float = 10.0
    megabytes: int = 2048


@dataclass(frozen=True)
class Result:
    """One case: its number, what became of it, and where it failed."""

    case: int
    outcome: Outcome
    where: str = ""


def tried(attempt: Callable[[int], None], cases: range, limits: Limits) -> Iterator[Result]:
    """Every case in turn, by number: ``attempt`` returns to accept it and raises to refuse it."""
    left = list(cases)
    while left:
        for result in _in_process(attempt, left[:BATCH], limits):
            left.pop(0)
            yield result


def _in_process(attempt: Callable[[int], None], cases: list[int], limits: Limits) -> Iterator[Result]:
    """Results up to the case that ended the process, that one included."""
    ours, theirs = os.pipe()
    pid = os.fork()
    if pid == 0:
        os.close(ours)
        _serve(attempt, cases, limits, theirs)
    os.close(theirs)
    try:
        yield from _answers(ours, pid, cases, limits)
    finally:
        os.close(ours)


def _answers(pipe: int, pid: int, cases: list[int], limits: Limits) -> Iterator[Result]:
    done = 0
    with open(pipe, "rb", closefd=False, buffering=0) as answers:
        text = b""
        while done < len(cases):
            ready, _, _ = select([pipe], [], [], WALL * limits.seconds)
            content = answers.read(65536) if ready else b""
            if not content:
                break
            text += content
            *lines, text = text.split(b"\n")
            for line in lines:
                outcome, _, where = line.decode().partition(" ")
                yield Result(cases[done], Outcome(outcome), where)
                done += 1
    is_waiting = done < len(cases) and not ready
    if is_waiting:
        os.kill(pid, signal.SIGKILL)
    _, status = os.waitpid(pid, 0)
    if done < len(cases):
        yield Result(cases[done], *_ended(status, is_waiting))


def _ended(status: int, is_waiting: bool) -> tuple[Outcome, str]:
    number = os.WTERMSIG(status) if os.WIFSIGNALED(status) else 0
    if is_waiting or number == signal.SIGPROF:
        return Outcome.HANG, "waits" if is_waiting else "runs on"
    return Outcome.CRASH, signal.Signals(number).name if number else f"exit {os.WEXITSTATUS(status)}"


def _serve(attempt: Callable[[int], None], cases: list[int], limits: Limits, pipe: int) -> None:
    """Try the cases one after the other and answer a line for each. Never returns."""
    code = 1
    try:
        faulthandler.disable()
        null = os.open(os.devnull, os.O_RDWR)
        for stream in (1, 2):
            os.dup2(null, stream)
        before = int(Path("/proc/self/statm").read_text().split()[5]) * resource.getpagesize()
        most = before + (limits.megabytes << 20)
        resource.setrlimit(resource.RLIMIT_DATA, (most, most))
        signal.signal(signal.SIGPROF, signal.SIG_DFL)
        for case in cases:
            signal.setitimer(signal.ITIMER_PROF, limits.seconds)
            outcome, where = _outcome(attempt, case)
            signal.setitimer(signal.ITIMER_PROF, 0.0)
            os.write(pipe, f"{outcome} {where}\n".encode("utf-8", "backslashreplace"))
        code = 0
    finally:
        os._exit(code)


def _outcome(attempt: Callable[[int], None], case: int) -> tuple[Outcome, str]:
    try:
        attempt(case)
    except ApcError as error:
        if error.exit_code in (3, 4, 5) and str(error).strip():
            return Outcome.REFUSED, ""
        return Outcome.TRACEBACK, _place(error)
    except MemoryError as error:
        return Outcome.MEMORY, _place(error)
    except BaseException as error:
        return Outcome.TRACEBACK, _place(error)
    return Outcome.ACCEPTED, ""


def _place(error: BaseException) -> str:
    """What was raised, and the innermost line of ours that led there."""
    frames = traceback.extract_tb(error.__traceback__)
    ours = [frame for frame in frames if "pickcli" in frame.filename] or list(frames)
    at = f"{ours[-1].filename.rpartition('pickcli/')[2]}:{ours[-1].lineno}" if ours else "?"
    return f"{at} {type(error).__name__}: {str(error)[:100]}".replace("\n", " ")


def counted(results: list[Result]) -> Counter[Outcome]:
    """How often each outcome came."""
    return Counter(result.outcome for result in results)
