"""apc watch-zone: output, files, picture, and mistakes."""

from __future__ import annotations

import json
from pathlib import Path
from xml.etree import ElementTree

import pytest

from pickcli.driving.driving_area_file import read_driving_area
from pickcli.watching.watch_file import watch_file
from pickcli.watching.watched_scene_file import read_watched_scene, scene_to_dict
from support.command_line import apc, misused, refused

HALL = """\
format: apc driving area
version: 1
walls: {low: [0, 0], high: [8, 6]}
boxes:
  - {name: shelf, centre: [4, 5], size: [2, 1]}
start: {position: [1.5, 3], yaw: 0}
goal: {position: [5, 3], yaw: 0}
"""
SCENE = """\
format: apc watched scene
version: 1
duration: 9
box_heights: {shelf: 1.5}
walkers:
  - {name: ann, route: [[4.6, 1], [4.6, 4.2]], speed: 0.8, start: 0.5, height: 1.7}
  - {name: "<bob>", route: [[7, 1]], speed: 0, has_vest: false}
reflectors:
  - {kind: sign, centre: [4, 4.49, 1.2], size: [0.4, 0.3], yaw: -1.57}
sun:
  - {centre: [3, 2], size: [1, 2], yaw: 0.4, strength: 8}
"""


@pytest.fixture
def hall(tmp_path: Path) -> Path:
    path = tmp_path / "hall.yaml"
    path.write_text(HALL)
    return path


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "scene.yaml"
    path.write_text(SCENE)
    return path


def test_a_stated_scene_is_played_told_and_written_alike_each_time(
    hall: Path, scene: Path, tmp_path: Path
) -> None:
    one, two, picture = tmp_path / "one.json", tmp_path / "two.json", tmp_path / "watch.svg"
    argv = ("watch-zone", hall, "--watched", scene, "--guards", "scanner", "--seed", 3)
    told = apc(*argv, "--picture", picture, "-o", one)
    assert told.code == 0, told.err
    assert "not at the goal after 9.0 s" in told.out and "brake request by the scanner, for ann" in told.out
    assert "nobody is touched while the truck moves" in told.out
    answer = apc(*argv, "--json", "-o", two)
    assert one.read_bytes() == two.read_bytes()
    written, figures = json.loads(one.read_text()), json.loads(answer.out)
    assert written["format"] == "apc watched drive"
    assert {key: figures[key] for key in written["figures"]} == written["figures"]
    assert figures["pictures"] == 0 and not figures["arrived"] and figures["touches"] == []
    assert len(written["fields"]) == len(figures["requests"]) >= 1
    field, request = written["fields"][0], figures["requests"][0]
    assert (field["speed"], field["steering"]) == (request["field_speed"], request["field_steering"])
    # It is for the speed that the truck gets to until it would brake.
    assert field["speed"] >= request["speed"] > 0 and field["stopping"] >= request["stopping"]
    assert len(field["outline"]) > 500
    refused(apc(*argv, "-o", one), 3, "--overwrite")
    root = ElementTree.parse(picture).getroot()
    titles = [element.text for element in root.iter() if element.tag.endswith("title")]
    assert {"shelf", "ann", "<bob>", "sun", "sign"} <= set(titles)
    assert any(title is not None and "brake request" in title for title in titles)


def test_the_scene_of_an_output_can_be_played_again(hall: Path, tmp_path: Path) -> None:
    drawn, again = tmp_path / "drawn.json", tmp_path / "again.json"
    argv = ("--guards", "scanner", "--seed", 8)
    assert apc("watch-zone", hall, *argv, "--people", 1, "-o", drawn).code == 0
    scene = tmp_path / "scene.json"
    scene.write_text(json.dumps(json.loads(drawn.read_text())["scene"]))
    assert apc("watch-zone", hall, *argv, "--watched", scene, "-o", again).code == 0
    assert drawn.read_bytes() == again.read_bytes()


@pytest.mark.slow
def test_vests_are_told(hall: Path, scene: Path, tmp_path: Path) -> None:
    scene.write_text(SCENE.replace("duration: 9", "duration: 2"))
    told = apc("watch-zone", hall, "--watched", scene, "-o", tmp_path / "out.json")
    assert told.code == 0, told.err
    assert "ann: seen at 0.1" in told.out and "probability" in told.out
    assert "0 tracks of nobody in 40 sets of pictures" in told.out and "not at the goal" in told.out


def test_a_scene_is_read_with_its_figures_and_written_the_same(
    hall: Path, scene: Path, tmp_path: Path
) -> None:
    area = read_driving_area(hall)
    found = read_watched_scene(scene, area)
    assert found.box_heights == (1.5,) and found.duration == 9
    ann, bob = found.walkers
    assert ann.route == ((4.6, 1.0), (4.6, 4.2)) and (ann.speed, ann.start, ann.height) == (0.8, 0.5, 1.7)
    assert ann.has_vest and not bob.has_vest
    copy = tmp_path / "copy.json"
    copy.write_text(json.dumps(scene_to_dict(found)))
    assert scene_to_dict(read_watched_scene(copy, area)) == scene_to_dict(found)


@pytest.mark.parametrize(
    ("right", "wrong", "told"),
    [
        ("speed: 0.8", "speed: -1", "walkers[0].speed"),
        ("speed: 0.8", "speed: .inf", "walkers[0].speed"),
        ("[4.6, 4.2]", "[4.6, 40]", ":6:17: walkers[0].route: ann leaves the walls; keep all places within"),
        ("[[4.6, 1], [4.6, 4.2]]", "[[1.5, 3], [4.6, 4.2]]", "ann begins where the truck starts; move one"),
        ("[[4.6, 1], [4.6, 4.2]]", "[]", "walkers[0].route"),
        ('"<bob>"', "ann", "ann is the name of another one, too; change one of them"),
        ("{shelf: 1.5}", "{shell: 1.5}", "the area has no box of that name; did you mean 'shelf'"),
        ("kind: sign", "kind: mirror", "reflectors[0].kind"),
        ("strength: 8", "strength: 0", "sun[0].strength"),
        ("duration: 9", "duration: 1000000", "duration"),
        ("height: 1.7", "hight: 1.7", "height"),
        ("apc watched scene", "apc driving area", "is a driving area"),
    ],
)  # fmt: skip
def test_mistakes_in_scenes_are_told(
    hall: Path, scene: Path, tmp_path: Path, right: str, wrong: str, told: str
) -> None:
    assert SCENE.count(right) == 1
    scene.write_text(SCENE.replace(right, wrong))
    out = tmp_path / "out.json"
    refused(apc("watch-zone", hall, "--watched", scene, "-o", out), 3, scene, told)
    assert not out.exists()


@pytest.mark.parametrize(
    ("right", "wrong", "told"),
    [
        ("range: [1.0, 20.0]", "range: [20.0, 1.0]", "expected range as [nearest, farthest], got"),
        ("gap: 0.004", "gap: 0.06", "expected a gap below the period of 0.05 s"),
        ("baseline: 0.4", "baseline: -0.4", "pair.baseline"),
        ("field_of_view: 1.7453", "field_of_view: 100", "pair.field_of_view"),
        ("scans: 2", "scans: 0", "scanner.scans"),
        ("hold: 1.0", "hold: .nan", "fields.hold"),
        ('  fields.hold: "ours"\n', "", "expected a source of fields.hold, got nothing; add it to sources"),
        ('  fields.hold: "ours"\n', '  fields.hold: "ours"\n  fields.fold: "ours"\n', "got fields.fold"),
        ("apc watch\n", "apc sensor\n", "is a sensor"),
    ],
)  # fmt: skip
def test_mistakes_in_watches_are_told(hall: Path, tmp_path: Path, right: str, wrong: str, told: str) -> None:
    text, path = watch_file("citi_truck").read_text(), tmp_path / "watch.yaml"
    assert text.count(right) == 1
    path.write_text(text.replace(right, wrong))
    out = tmp_path / "out.json"
    refused(apc("watch-zone", hall, "--watch", path, "-o", out), 3, path, told)
    assert not out.exists()


def test_wrong_names_and_numbers_are_refused(hall: Path, tmp_path: Path) -> None:
    out = tmp_path / "out.json"
    refused(apc("watch-zone", hall, "--watch", "citi_track", "-o", out), 3, "citi_track", "citi_truck")
    refused(apc("watch-zone", tmp_path / "no.yaml", "-o", out), 3, "no.yaml")
    refused(apc("watch-zone", hall, "--watched", tmp_path / "no.yaml", "-o", out), 3, "no.yaml")
    refused(apc("watch-zone", hall, "--picture", tmp_path / "a.png", "-o", out), 3, "a.png", ".svg")
    misused(apc("watch-zone", hall, "--people", 50, "-o", out), "--people")
    misused(apc("watch-zone", hall, "--guards", "none", "-o", out), "--guards")
    assert not out.exists()
