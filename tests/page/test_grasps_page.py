"""The page of an item: its regions where they are, an arrow for each candidate."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pickcli.cell.cell_file import load_cell
from pickcli.errors import Reason
from pickcli.files.packed_array import unpacked
from pickcli.geometry import pose
from pickcli.grasping.grasp_target import CandidateSet, GraspTarget
from pickcli.grasping.suction_candidates import sample_suctions
from pickcli.grasping.surfaces import faces
from pickcli.page.grasps_page import grasps_page
from pickcli.page.html_page import page_bytes
from pickcli.page.page_document import PageDocument
from support.browser import browser

CELL = load_cell("apc2016_delft")
TOOL, BIN = CELL.robot.tool, CELL.pod.bins["bin_E"]


def found(name: str) -> CandidateSet:
    target = GraspTarget(name, CELL.item(name), pose([0.25, 0.0, 0.05]), BIN)
    return sample_suctions(target, TOOL, np.random.default_rng(0))


def shown(name: str) -> PageDocument:
    return grasps_page(CELL.item(name), TOOL, "bin_E", found(name))


@pytest.mark.parametrize(
    "name", ["crayola_24_ct", "dasani_water_bottle", "rawlings_baseball", "platinum_pets_dog_bowl"]
)
def test_regions_lie_where_the_centre_of_the_cup_may_be(name: str) -> None:
    item, document = CELL.item(name), shown(name)
    regions = {f"region {face.name}": face.region for face in faces(item, TOOL)}
    assert [group.name for group in document.groups] == list(regions)
    for group in document.groups:
        (body,) = group.bodies
        points = regions[group.name].sample(np.random.default_rng(1), 200)[:, :3, 3] - body.pose[:3]
        reach = np.linalg.norm(body.shape.size) if body.shape.kind != "sphere" else body.shape.size[0]
        assert (np.linalg.norm(points, axis=1) <= reach + 1e-3).all()


def test_arrows_end_on_the_item_and_come_from_outside() -> None:
    candidates, document = found("crayola_24_ct"), shown("crayola_24_ct")
    assert len(document.lines) == len(candidates.grasps) > 5
    for line, grasp in zip(document.lines, candidates.grasps, strict=True):
        start, end = unpacked(line.points)
        np.testing.assert_allclose(end, grasp.T_item_tip[:3, 3], atol=1e-4)
        assert (end - start) @ grasp.T_item_tip[:3, 2] == pytest.approx(0.04, abs=3e-4)
    assert [row[3] for row in document.tables[1].rows] == [f"{g.load_ratio:.0%}" for g in candidates.grasps]


def test_what_was_dropped_is_counted_by_reason() -> None:
    dropped = CandidateSet((), (Reason("too heavy", "a"), Reason("too heavy", "b")))
    facts = grasps_page(CELL.item("crayola_24_ct"), TOOL, "bin_E", dropped).facts
    assert ("dropped", "2: too heavy") in {(fact.label, fact.value) for fact in facts}


@pytest.mark.slow
def test_the_page_opens_in_a_browser(chromium: str, tmp_path: Path) -> None:
    page = tmp_path / "grasps.html"
    page.write_bytes(page_bytes(shown("dasani_water_bottle")))
    with browser(chromium) as opened:
        opened.open(page)
        assert opened.run("apcPage.stage.items.size") == 1
        assert "dasani water bottle" in opened.run("document.body.textContent")
        assert opened.errors == []
