"""People in the booth: the truck brakes for them and goes on, and says so; who stays ends the drive."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from pickcli.commission.booth_people import (
    BESIDE,
    DRIVES,
    SHYNESS,
    DrawnPeople,
    StatedPeople,
    TurningWalker,
)
from pickcli.commission.commission_result import ActionError
from pickcli.commission.commission_station import CommissionStation
from pickcli.commission.commission_truck import CommissionTruck
from pickcli.commission.people_watch import BoothWatch, PeopleWatch
from pickcli.driving.driving_area import DrivingArea
from pickcli.driving.simulated_drives import DriveNoise
from pickcli.watching.drive_watch import Guards
from pickcli.watching.foreseen_contact import outline_distance
from pickcli.watching.watch_file import read_watch, watch_file
from pickcli.watching.watched_scene import Walker
from support.command_line import apc, misused, refused
from support.commissions import SHIPPED, few, station_of, written
from support.page_files import document_of

SCANNERS = Guards(vests=False)


@pytest.fixture(scope="module")
def station(tmp_path_factory: pytest.TempPathFactory) -> CommissionStation:
    return station_of(written(tmp_path_factory.mktemp("one"), lambda data: few(data, "coke")))


def in_the_pallet(station: CommissionStation, *walkers: Walker) -> CommissionTruck:
    """A truck that has the pallet on its forks, and drives past people by its scanners."""
    booth = BoothWatch(StatedPeople(walkers), read_watch(watch_file("apple_booth")), SCANNERS)

    def oversee(name: str, area: DrivingArea) -> PeopleWatch:
        return PeopleWatch(booth, name, area, 0.0, 3, 0)

    truck = CommissionTruck(station, DriveNoise(), 3, oversee)
    truck._truck.true[:] = truck._truck.believed[:] = station.commission.area.goal
    truck.on_forks, truck.is_raised = station.pallet_in_truck, True
    return truck


def test_the_truck_brakes_for_who_crosses_and_goes_on(station: CommissionStation) -> None:
    truck = in_the_pallet(station, Walker("anna", ((4.2, -0.8), (4.2, 3.8)), 0.8))
    drive = truck.to_load()
    assert drive is not None and drive.watched is not None
    assert drive.figures["braked_s"] > 1.0 and drive.figures["brake_requests"] >= 1
    assert drive.figures["touched"] == [] and truck.n_collisions == 0
    assert drive.figures["off_m"] < 0.03 and drive.figures["people"] == 1
    free = in_the_pallet(station).to_load()
    assert free is not None and free.figures["braked_s"] == 0.0
    assert drive.duration > free.duration + 1.0
    (anna,) = drive.watched.people
    assert np.abs(anna.places[0] - [4.2, -0.8]).max() == 0.0 and len(anna.places) > 50


def test_who_stays_before_the_truck_ends_the_drive_by_name(
    station: CommissionStation, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pickcli.commission.people_watch.MOST_WAIT", 4.0)
    monkeypatch.setattr("pickcli.commission.commission_truck.MOST_WAIT", 4.0)
    truck = in_the_pallet(station, Walker("bert", ((3.9, 1.1),), 0.0))
    with pytest.raises(ActionError, match="stayed in the protective field: the truck did not get on for 4 s"):
        truck.to_load()
    assert truck.n_collisions == 0 and truck.drives[-1].figures["braked_s"] > 2.0
    near = outline_distance(station.commission.area.truck, truck.true[None], np.array([[3.9, 1.1]]))[0]
    assert near > 0.3


def test_backwards_the_rear_scanner_looks(station: CommissionStation) -> None:
    """Somebody crosses behind the truck as it goes backwards into the pallet."""
    watch = read_watch(watch_file("apple_booth"))
    assert watch.rear is not None and watch.rear.looks_back and not watch.scanner.looks_back
    walker = Walker("cleo", ((1.6, -0.8), (1.6, 3.8)), 0.4)
    booth = BoothWatch(StatedPeople((walker,)), watch, SCANNERS)
    truck = CommissionTruck(
        station, DriveNoise(), 5, lambda name, area: PeopleWatch(booth, name, area, 0.0, 5, 0)
    )
    try:
        truck.enter()
    except ActionError as error:
        assert "the pallet was not seen" in str(error)  # it may have come into view too late
    assert truck.drives[-1].figures["brake_requests"] >= 1 and truck.n_collisions == 0


def test_a_person_turns_round_before_the_truck(station: CommissionStation) -> None:
    area = station.commission.area
    walker = TurningWalker("dora", ((0.0, 1.1), (5.0, 1.1)), 1.0)
    truck = np.array([3.3, 1.1, 0.0])  # its forks end at x = 3
    for time in np.arange(0.0, 6.0, 0.02).tolist():
        walker.avoid(time, area, truck)
    (turned,) = walker.turned
    assert walker.place(turned)[0] == pytest.approx(3.0 - SHYNESS, abs=0.03)
    assert walker.place(turned + 1.0)[0] == pytest.approx(3.0 - SHYNESS - 1.0, abs=0.03)
    assert walker.place(turned - 1.0)[0] == pytest.approx(3.0 - SHYNESS - 1.0, abs=0.03)
    assert walker.place(60.0)[0] == 0.0
    assert walker.heading(turned + 0.5) == pytest.approx(walker.heading(turned - 0.5) + np.pi)


def test_drawn_people_come_once_through_the_booth_and_keep_away_from_boxes(
    station: CommissionStation,
) -> None:
    area = station.entering(station.commission.area.start)
    came = [each for drive in DRIVES for each in DrawnPeople(8).during(drive, 10.0, area, 4)]
    assert sorted(each.name for each in came) == [f"person {k}" for k in range(1, 9)]
    again = [each for drive in DRIVES for each in DrawnPeople(8).during(drive, 90.0, area, 4)]
    assert came == again
    assert came != [each for drive in DRIVES for each in DrawnPeople(8).during(drive, 10.0, area, 5)]
    for each in came:
        ends = np.array(each.route)
        assert (area.wall_distance(ends) < -0.5).all()
        way = np.linspace(ends[0], ends[1], 100)
        assert min(box.distance(way).min() for box in area.boxes) > BESIDE - 0.02


def test_options_that_do_not_fit_are_refused(tmp_path: Path) -> None:
    out = tmp_path / "out"
    misused(apc("run-trial", "jsk_pick_sample", "--people", 3, "-o", out), "--people applies to commissions")
    misused(apc("run-trials", "jsk_pick_sample", "--guards", "both", "-o", out), "--guards applies to comm")
    misused(apc("run-trial", SHIPPED, "--guards", "vests", "-o", out), "add --people")
    misused(apc("run-trial", SHIPPED, "--people", 21, "-o", out), "at most 20")
    refused(apc("run-trial", SHIPPED, "--people", tmp_path / "none.yaml", "-o", out), 3, "none.yaml")
    scene = tmp_path / "people.json"
    walker = {"name": "emil", "route": [[9, 1], [2, 1]]}
    scene.write_text(json.dumps({"format": "apc watched scene", "version": 1, "walkers": [walker]}))
    refused(apc("run-trial", SHIPPED, "--people", scene, "-o", out), 3, scene, "emil leaves the walls")
    assert not out.exists()


@pytest.mark.slow
def test_a_commission_past_people_tells_of_them(tmp_path: Path) -> None:
    path = written(tmp_path, lambda data: few(data, "coke"))
    told = apc("run-trial", path, "--people", 6, "--guards", "scanner", "--seed", 2, "-o", tmp_path / "run")
    assert told.code == 0 and "s for people" in told.out and "nobody touched by the truck" in told.out
    record = json.loads((tmp_path / "run" / "trial.json").read_text())
    assert record["people"]["number"] >= 4 and record["people"]["braked_s"] > 0.0
    assert record["people"]["touched"] == record["collisions"] == 0 and record["success"]
    assert apc("show", tmp_path / "run", "-o", tmp_path / "run.html").code == 0
    assert "person 1" in json.dumps(document_of((tmp_path / "run.html").read_bytes()))
