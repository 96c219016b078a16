"""What is fuzzed: for each kind of input, sound files to begin with and what reads them."""

from __future__ import annotations

import gzip
import json
import shutil
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from bench.fuzz.mutate import NUMBERS, as_json, mutated_bytes, mutated_value
from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.cell.data_path import data_path
from pickcli.cell.robots.urdf import read_urdf
from pickcli.cell.schemas.cell_schema import CellModel
from pickcli.cell.schemas.items_file import ItemsModel, read_items
from pickcli.cell.schemas.sensor_file import SensorFileModel, read_sensor, sensor_file, sensor_names
from pickcli.cell.tool import MOVING
from pickcli.errors import RejectedError
from pickcli.files.atomic_write import write_bytes
from pickcli.files.schema import FileModel, validate
from pickcli.files.yaml_reader import read_yaml
from pickcli.motion.path import JointPath
from pickcli.motion.plan import Plan
from pickcli.motion.plan_file import read_plan, write_plan
from pickcli.motion.trajectory import Trajectory
from pickcli.page.html_page import page_bytes
from pickcli.page.trial_page import trial_page
from pickcli.page.trials_page import trials_page
from pickcli.perception.depth_picture import kernel_noise
from pickcli.roadmap.graph import Roadmap
from pickcli.roadmap.store import (
    describe,
    read_database,
    read_gaps,
    read_missing,
    read_roadmap,
    surveyed,
    write_database,
    write_roadmap,
)
from pickcli.roadmap.trajectory_database import CoarseMotion, MotionKey, PayloadClass, TrajectoryDatabase
from pickcli.scene.scene import PoseNoise, Scene
from pickcli.scene.scene_file import read_scene, scene_hash, write_scene
from pickcli.seeds import derived_rng
from pickcli.simulation.reality import read_reality
from pickcli.trial.motion_record import motion_values, read_motion, refuse_other_motion
from pickcli.trial.order import Order
from pickcli.trial.order_file import read_order
from pickcli.trial.trial_record import read_record, trial_record
from pickcli.verification.verify import verify

Attempt = Callable[[int], None]

ITEM = "dove_beauty_bar"


@dataclass(frozen=True)
class Kind:
    """One kind of input.

    share: of all cases
    attempt: the case of that number: makes the input, has it read, and returns if it was accepted
    """

    name: str
    share: float
    attempt: Attempt


@dataclass(frozen=True, eq=False)
class Sound:
    """What is broken: a cell, a scene in it, a plan for it, all as they should be."""

    cell: Cell
    scene: Scene
    plan: Plan
    order: dict[str, Any]


def sound() -> Sound:
    """A small order, its scene, and a pick that the verifier accepts."""
    from pickcli.planning.pick import plan_pick
    from pickcli.planning.pick_problem import PickQuery
    from pickcli.planning.planning_context import PlanningContext
    from pickcli.planning.start_state import Start
    from pickcli.random_scenes.make_scene import make_scene
    from pickcli.verification.verify import certify

    cell = load_cell("apc2016_delft")
    bins: dict[str, list[str]] = {name: [] for name in cell.pod.bins}
    bins["bin_C"] = [ITEM, "crayola_24_ct"]
    scene = make_scene(bins, cell, 3)
    begin = Start(cell.configurations["home"].q, cell.robot.tool.default_state)
    plan = certify(
        plan_pick(PlanningContext(cell, None, None), scene, PickQuery("bin_C", ITEM), begin, 0), scene
    )
    order = {"bin_contents": bins, "tote_contents": [], "work_order": [{"bin": "bin_C", "item": ITEM}]}
    return Sound(cell, scene, plan, order)


def kinds(of: Sound, folder: Path, seed: int) -> tuple[Kind, ...]:
    """All kinds of input, written into ``folder`` case by case."""
    make = _Maker(of, folder, seed)
    return (
        Kind("orders", 0.14, make.order),
        Kind("items", 0.10, make.items),
        Kind("sensors", 0.04, make.sensor),
        Kind("URDF", 0.14, make.urdf),
        Kind("scenes", 0.10, make.scene),
        Kind("cells", 0.06, make.cell),
        Kind("reality", 0.05, make.reality),
        Kind("plans", 0.14, make.plan),
        Kind("plans of extreme numbers", 0.07, make.extreme),
        Kind("HDF5 stores", 0.11, make.store),
        Kind("trials", 0.05, make.trial),
    )


class _Maker:
    """Makes the input of each case, and has it read."""

    def __init__(self, of: Sound, folder: Path, seed: int) -> None:
        self.of, self.folder, self.seed = of, folder, seed
        cell, path = of.cell, of.cell.path
        self._scene_text = self._written("scene.json", lambda path: write_scene(of.scene, path))
        plain = replace(of.plan, certificate=None, statistics={})
        self._plan_texts = (
            self._written("certified.json", lambda path: write_plan(of.plan, path)),
            self._written("plan.json", lambda path: write_plan(plain, path)),
        )
        self._cell_text, self._urdf_text = (
            (path / "cell.yaml").read_bytes(),
            (path / "robot.urdf").read_bytes(),
        )
        self._items_texts = [path.read_bytes() for path in sorted((data_path() / "items").glob("*.yaml"))]
        self._sensor_texts = [path.read_bytes() for path in map(sensor_file, sensor_names())]
        items = data_path() / "items" / "apc2016.yaml"
        self._models = {
            "cell": _plain(validate(read_yaml(path / "cell.yaml"), CellModel)),
            "items": _plain(validate(read_yaml(items), ItemsModel)),
            "sensor": _plain(validate(read_yaml(sensor_file("carmine")), SensorFileModel)),
        }
        made: tuple[str, dict[str, Any]] = (cell.fingerprint, {})
        self._stores = (
            self._written("roadmap.h5", lambda path: write_roadmap(path, _roadmap(cell), *made)),
            self._written("database.h5", lambda path: write_database(path, _database(cell), *made)),
        )

        self._trial_texts = _trial_texts(of, read_order(self._put("order.json", as_json(of.order)), cell))

    def order(self, case: int) -> None:
        """An order."""
        rng = self._rng("order", case)
        content = as_json(self.of.order)
        read_order(self._put("order.json", self._json(content, self.of.order, rng)), self.of.cell)

    def items(self, case: int) -> None:
        """A file of items."""
        rng = self._rng("items", case)
        text = self._items_texts[int(rng.integers(len(self._items_texts)))]
        read_items(self._put("items.yaml", self._json(text, self._models["items"], rng)))

    def sensor(self, case: int) -> None:
        """A file of a sensor; the kernel takes what is accepted."""
        rng = self._rng("sensors", case)
        text = self._sensor_texts[int(rng.integers(len(self._sensor_texts)))]
        sensor = read_sensor(self._put("sensor.yaml", self._json(text, self._models["sensor"], rng)))
        if sensor.depth is not None:
            kernel_noise(sensor.depth)

    def urdf(self, case: int) -> None:
        """A URDF."""
        read_urdf(self._put("robot.urdf", mutated_bytes(self._urdf_text, self._rng("urdf", case))))

    def scene(self, case: int) -> None:
        """A scene; one that is accepted also gets its hash."""
        content = self._json(self._scene_text, json.loads(self._scene_text), self._rng("scene", case))
        scene_hash(read_scene(self._put("scene.json", content), self.of.cell))

    def cell(self, case: int) -> None:
        """A cell's folder; of one that is accepted a few configurations are also tested for collision."""
        rng = self._rng("cell", case)
        text, urdf = self._json(self._cell_text, self._models["cell"], rng), self._urdf_text
        if rng.random() < 0.4:
            text, urdf = self._cell_text, mutated_bytes(urdf, rng)
        folder = self.folder / "cell"
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir()
        write_bytes(folder / "robot.urdf", urdf)
        write_bytes(folder / "cell.yaml", text)
        _use(load_cell(folder))

    def reality(self, case: int) -> None:
        """Levels of the simulated world."""
        levels = {"format": "apc reality", "version": 1, "mass_error": 0.05, "servo": False, "look_time": 2.0}
        read_reality(
            self._put("reality.yaml", self._json(as_json(levels), levels, self._rng("reality", case)))
        )

    def plan(self, case: int) -> None:
        """A plan; one that is accepted as a file goes to the verifier."""
        rng = self._rng("plan", case)
        text = self._plan_texts[int(rng.random() < 0.9)]
        path = self._put("plan.json", self._json(text, None, rng))
        self._verify(read_plan(path))

    def extreme(self, case: int) -> None:
        """A plan as the verifier gets it from a program, its numbers finite and of any size."""
        rng = self._rng("extreme", case)
        self._verify(_extreme(replace(self.of.plan, certificate=None), rng))

    def store(self, case: int) -> None:
        """A roadmap or database, read in every way."""
        rng = self._rng("store", case)
        which = int(rng.integers(2))
        path = self._put("store.h5", mutated_bytes(self._stores[which], rng))
        readers: list[Callable[[Path], object]] = [describe, surveyed]
        readers += [read_gaps, read_roadmap] if which == 0 else [read_missing, read_database]
        readers[int(rng.integers(len(readers)))](path)

    def trial(self, case: int) -> None:
        """The folder of a trial: its record or its motion; both make pages, where they are accepted."""
        rng = self._rng("trial", case)
        texts = list(self._trial_texts)
        which = int(rng.integers(2))
        texts[which] = self._json(texts[which], None, rng)
        zipped = gzip.compress(texts[1], mtime=0)
        if which == 1 and rng.random() < 0.3:
            zipped = mutated_bytes(zipped, rng)
        record = read_record(self._put("trial.json", texts[0]))
        motion = read_motion(self._put("motion.json.gz", zipped))
        refuse_other_motion(motion, self.of.scene, [self.of.cell], "motion.json.gz")
        page_bytes(trial_page(record, self.of.scene, motion))
        page_bytes(trials_page({"a": record}))

    def _verify(self, plan: Plan) -> None:
        verdict = verify(plan, self.of.scene)
        if verdict.certificate is None:
            raise RejectedError("; ".join(map(str, verdict.reasons)))

    def _json(self, text: bytes, value: Any, rng: np.random.Generator) -> bytes:
        """A text broken as text, or the value it stands for broken as a value."""
        if rng.random() < 0.35:
            return mutated_bytes(text, rng)
        return as_json(mutated_value(json.loads(text) if value is None else value, rng))

    def _rng(self, kind: str, case: int) -> np.random.Generator:
        return derived_rng("fuzz", self.seed, kind, case)

    def _put(self, name: str, content: bytes) -> Path:
        path = self.folder / name
        path.write_bytes(content)
        return path

    def _written(self, name: str, write: Callable[[Path], None]) -> bytes:
        path = self.folder / name
        write(path)
        return path.read_bytes()


def _trial_texts(of: Sound, order: Order) -> tuple[bytes, bytes]:
    """The record of a trial, and what moved in it."""
    from pickcli.planning.planning_context import PlanningContext
    from pickcli.simulation.motion_recorder import MotionRecorder
    from pickcli.trial.loop import run_trial
    from pickcli.trial.simulated_cell import SimulatedArena, TrialArm, interfaces_of
    from pickcli.trial.trial_settings import TrialSettings

    recorder = MotionRecorder()
    arena = SimulatedArena(of.scene, motion_recorder=recorder)
    context = TrialArm(PlanningContext(of.cell, None, None))
    result = run_trial(order, interfaces_of([context], arena), TrialSettings(0, PoseNoise()))
    arena.close()
    record = trial_record(result, "order.json", 0.0)
    return as_json(record), as_json(motion_values(recorder, [of.cell]))


def _plain(model: FileModel) -> Any:
    """What stood in a file, as JSON values."""
    return json.loads(model.model_dump_json(exclude_unset=True, exclude_none=True))


def _use(cell: Cell) -> None:
    """What every command does with a cell first."""
    from pickcli.planning.planning_context import PlanningContext

    context = PlanningContext(cell, None, None)
    del context


def _extreme(plan: Plan, rng: np.random.Generator) -> Plan:
    """A plan with some numbers of its motion, segments, events or grasp replaced by any that are finite."""
    finite = [float(n) for n in NUMBERS[:23] if isinstance(n, (int, float)) and abs(n) < 1e309]
    trajectory = plan.trajectory
    for _ in range(int(rng.integers(1, 4))):
        name = str(rng.choice(["times", "positions", "velocities", "accelerations"]))
        values = getattr(trajectory, name).copy()
        how = int(rng.integers(3))
        if how == 0:
            values *= float(rng.choice([1e-300, 1e-12, 1e-6, 0.1, 0.5, 2.0, 10.0, 1e3, 1e9, 1e300]))
        else:
            rows = rng.integers(0, len(values), int(rng.integers(1, 5)))
            columns = (
                (slice(None),) if how == 1 or values.ndim == 1 else (int(rng.integers(values.shape[1])),)
            )
            values[(rows, *columns) if values.ndim == 2 else rows] = float(rng.choice(finite))
        trajectory = replace(trajectory, **{name: np.nan_to_num(values, posinf=1.7e308, neginf=-1.7e308)})
    plan = replace(plan, trajectory=trajectory)
    k, number = int(rng.integers(4)), float(rng.choice(finite))
    if k == 0 and plan.grasp is not None:
        T = plan.grasp.T_item_tip.copy()
        T[int(rng.integers(3)), 3] = number
        plan = replace(plan, grasp=replace(plan.grasp, T_item_tip=T))
    elif k == 1:
        i = int(rng.integers(len(plan.segments)))
        moved = replace(plan.segments[i], t_end=number)
        plan = replace(plan, segments=(*plan.segments[:i], moved, *plan.segments[i + 1 :]))
    elif k == 2:
        i = int(rng.integers(len(plan.events)))
        shifted = replace(plan.events[i], t_anchor=number)
        plan = replace(plan, events=(*plan.events[:i], shifted, *plan.events[i + 1 :]))
    return plan


def _roadmap(cell: Cell) -> Roadmap:
    """Five named configurations in a row."""
    built = Roadmap.empty(cell.robot.joint_names)
    for named in list(cell.configurations.values())[:5]:
        built, _ = built.with_node(named.q, named.name, named.tool_state)
    for a in range(4):
        ends = built.configurations[[a, a + 1]]
        built = built.with_edge(a, a + 1, np.stack([ends[0], ends.mean(axis=0), ends[1]]))
    return built


def _database(cell: Cell) -> TrajectoryDatabase:
    """Two motions between named configurations, each one quintic."""
    named, joints = list(cell.configurations.values())[:3], cell.robot.joint_names
    motions = []
    for a, b in pairwise(named):
        ends, still = np.stack([a.q, b.q]), np.zeros((2, len(joints)))
        timed = Trajectory(joints, np.array([0.0, 9.0]), ends, still, still)
        key = MotionKey(a.name, b.name, PayloadClass.EMPTY)
        motions.append(CoarseMotion(key, MOVING, JointPath(joints, ends), 9.0, timed))
    return TrajectoryDatabase.of(joints, motions)
