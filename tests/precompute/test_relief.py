"""What holds for the pod in its place alone, after what was in the way of its sweep went away."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.cell_diff import change_since, parts_of
from pickcli.cell.pod_tolerance import PodPoses
from pickcli.cell.shapes import box
from pickcli.cell.station import Obstacles
from pickcli.cell.tool import MOVING
from pickcli.precompute.artifact_files import make_roadmap
from pickcli.precompute.refreshing import refresh
from pickcli.precompute.revalidation import Revalidation
from pickcli.roadmap.store import read_database, read_roadmap, surveyed
from pickcli.roadmap.trajectory_database import PayloadClass
from support.changed_cell import built, moved_divider, refreshed, shifted, with_parts
from support.small_cell import small_cell
from support.stored_kind import FEW_EDGES
from support.tool_states import STRAIGHT

# Each stands in the way around the sweep of the pod between two configurations, and not in the way that is
# free for the pod in its place: so that is what is stored while they stand. Those of the pod are swept
# with it, and smaller for that.
POSTS = (
    box("post_at_KL", (-0.62, -0.25, 0.80), (-0.43, -0.13, 0.97)),
    box("post_at_KB", (-0.68, 0.17, 1.17), (-0.52, 0.33, 1.33)),
)
POD_POSTS = (
    box("post_at_KL", (-0.62, -0.25, 0.80), (-0.43, -0.13, 0.96)),
    box("post_at_KB", (-0.65, 0.38, 1.28), (-0.49, 0.54, 1.44)),
)
AMONG_POSTS = ("bin_K", "cam_B", "cam_K", "cam_L")


def _posts_as_obstacles(cell: Cell) -> Cell:
    return with_parts(cell, obstacles=Obstacles((*cell.obstacles.bodies, *POSTS)))


def _posts_of_the_pod(cell: Cell) -> Cell:
    return with_parts(cell, pod=replace(cell.pod, bodies=(*cell.pod.bodies, *POD_POSTS)))


def _pod_poses(folder: Path, cell: Cell) -> dict[str, dict[object, PodPoses]]:
    """For which pods each edge and each motion of a folder's files holds."""
    motions, roadmap = read_database(folder / "motions", cell), read_roadmap(folder / "edges", cell)
    pairs = [tuple(roadmap.names[node] for node in edge) for edge in roadmap.edges]
    return {
        "edges": {pair: validity.pod_poses for pair, validity in zip(pairs, roadmap.validities, strict=True)},
        "motions": {motion.key: motion.validity.pod_poses for motion in motions},
    }


@pytest.mark.parametrize("posts", [_posts_as_obstacles, _posts_of_the_pod])
def test_what_went_away_makes_room_for_any_pod(posts: Callable[[Cell], Cell], tmp_path: Path) -> None:
    """Also where it was not in the way that is stored."""
    bare = small_cell(*AMONG_POSTS)
    old, new = built(posts(bare), tmp_path), tmp_path / "new"
    assert set(old) == {"motions", "edges"}
    before = _pod_poses(tmp_path, posts(bare))
    for kind, content in old.items():
        done = refreshed(tmp_path / kind, content, bare)
        assert done.n_kept > 0 and done.n_proven == 0
    new.mkdir()
    built(bare, new)
    ours, fresh = _pod_poses(tmp_path, bare), _pod_poses(new, bare)
    for kind, stands in before.items():
        nominal = [key for key, pod_poses in stands.items() if pod_poses is PodPoses.NOMINAL]
        assert {key: ours[kind][key] for key in nominal} == {key: fresh[kind][key] for key in nominal}
        assert any(ours[kind][key] is PodPoses.DISPLACED for key in nominal)
        assert all(
            pod_poses is PodPoses.DISPLACED for key, pod_poses in ours[kind].items() if key not in nominal
        )


# As a part of the pod, its sweep is in the way from bin_K to cam_B, and free of both.
FLAP = box("flap", (-0.59, 0.12, 1.06), (-0.45, 0.20, 1.24))


@pytest.mark.parametrize(("by", "pod_poses"), [(1.0, PodPoses.DISPLACED), (-0.01, PodPoses.NOMINAL)])
def test_a_part_of_the_pod_that_moved_makes_room_if_it_leaves_the_way(
    by: float, pod_poses: PodPoses, tmp_path: Path
) -> None:
    bare, path = small_cell("bin_K", "cam_B"), tmp_path / "edges"
    then, now = (
        with_parts(bare, pod=replace(bare.pod, bodies=(*bare.pod.bodies, shifted(FLAP, 0.0, 0.0, z))))
        for z in (0.0, by)
    )
    make_roadmap(then, path, FEW_EDGES)
    assert [validity.pod_poses for validity in read_roadmap(path, then).validities] == [PodPoses.NOMINAL]
    done = refresh(path, surveyed(path), now)
    assert (done.changed, done.n_planned) == (("pod flap",), int(pod_poses is PodPoses.DISPLACED))
    assert [validity.pod_poses for validity in read_roadmap(path, now).validities] == [pod_poses]


def test_room_for_any_pod_is_looked_for_where_it_may_be() -> None:
    cell = small_cell("home", "cam_E")
    ends = np.stack([cell.configurations[name].q for name in ("home", "cam_E")])
    bare, posts = parts_of(cell), _posts_as_obstacles(cell)
    assert cell.tote is not None
    tote = replace(cell.tote, bodies=tuple(shifted(body, 0.0, 0.01, 0.0) for body in cell.tote_bodies))

    def is_worth_replanning(cell: Cell, before: object, payload: PayloadClass = PayloadClass.EMPTY) -> bool:
        tool_state = MOVING if payload is PayloadClass.EMPTY else STRAIGHT
        return Revalidation(cell, change_since(before, cell)).is_worth_replanning(ends, tool_state, payload)  # type: ignore[arg-type]

    assert is_worth_replanning(cell, parts_of(posts)), "what was there went"
    assert not is_worth_replanning(cell, parts_of(posts), PayloadClass.CENTRED_CUBE), (
        "an end is within the sweep"
    )
    assert not is_worth_replanning(posts, bare), "nothing went"
    assert is_worth_replanning(with_parts(cell, tote=tote), bare), "the tote moved"
    assert not is_worth_replanning(moved_divider(cell), bare), (
        "a part of the pod moved that was not in the way"
    )
