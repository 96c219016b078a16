"""A peer in a process and an environment of its own; started by ``bench.peers.process``.

    python -m bench.peers.worker PEER QUERIES.json

Answers on stdout, a line of JSON each: first its versions, or why it cannot work; then, for each line with
the number of a query on stdin, the paths and the seconds they took. What a library prints goes to stderr.
"""

from __future__ import annotations

import importlib
import json
import os
import sys
import time
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np


def main() -> None:
    """Serve until stdin ends."""
    with os.fdopen(os.dup(1), "w") as out:
        os.dup2(2, 1)
        try:
            module = importlib.import_module(f"bench.peers.{sys.argv[1]}")
            problem = json.loads(Path(sys.argv[2]).read_text())
            peer = module.Peer(problem)
        except Exception as error:
            _say(out, {"error": f"{type(error).__name__}: {error}"})
            return
        _say(out, {"versions": {name: version(name) for name in module.PACKAGES}})
        for line in sys.stdin:
            _say(out, _answer(peer, problem["queries"][int(line)], int(line)))


def _answer(peer: Any, query: dict[str, Any], number: int) -> dict[str, Any]:
    """The first path, then the path as the peer itself shortens it; None for a path that there is not."""
    peer.prepare(query, number)
    start, goal = np.array(query["start"]), np.array(query["goal"])
    began, began_cpu = time.perf_counter(), time.process_time()
    path = peer.plan(start, goal)
    first_s, first_cpu_s = time.perf_counter() - began, time.process_time() - began_cpu
    answer = {
        "first": None,
        "first_s": first_s,
        "first_cpu_s": first_cpu_s,
        "short": None,
        "short_s": first_s,
    }
    if path is None:
        return answer
    answer["first"] = np.asarray(path.waypoints() if hasattr(path, "waypoints") else path).tolist()
    began = time.perf_counter()
    answer["short"] = np.asarray(peer.shortened(path)).tolist()
    answer["short_s"] = first_s + time.perf_counter() - began
    return answer


def _say(out: Any, answer: dict[str, Any]) -> None:
    out.write(json.dumps(answer) + "\n")
    out.flush()


if __name__ == "__main__":
    main()
