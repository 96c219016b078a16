"""A file handed in where another kind is wanted: one line that says what it is and what is wanted."""

from __future__ import annotations

from pathlib import Path

import click
import pytest

from pickcli.cell.cell_file import load_cell
from pickcli.cell.data_path import data_path
from pickcli.commands import main as cli
from pickcli.files.file_kind import (
    CELL,
    COMMISSION,
    DETECTED,
    DRIVE,
    DRIVING_AREA,
    GRASPS,
    HAND,
    ITEMS,
    JOINT_LIMITS,
    KINDS,
    ORDER,
    PALLET,
    PERCEIVED,
    PICTURE,
    PLAN,
    REALITY,
    RECORDING,
    SCENE,
    SENSOR,
    SRDF,
    STACK,
    STACKED,
    STORE,
    STRATEGY,
    STREAM,
    TOTE,
    TRIAL,
    TRIALS,
    TSRS,
    URDF,
    WATCH,
    WATCHED_DRIVE,
    WATCHED_SCENE,
    FileKind,
)
from pickcli.roadmap.graph import Roadmap
from pickcli.roadmap.store import write_roadmap
from support.command_line import ITEM, Made, apc, refused

# What every command reads, by the name of the parameter.
READ: dict[str, dict[str, FileKind | None]] = {
    "init": {"urdf": URDF, "srdf": SRDF, "joint_limits": JOINT_LIMITS},
    "build-roadmap": {"cell_name": CELL},
    "build-trajectories": {"cell_name": CELL},
    "suggest-configurations": {"cell_name": CELL},
    "suggest-mount": {"cell_name": CELL},
    "compare-planners": {"cell_name": CELL, "stream_path": STREAM},
    "record-grasp": {"plan_path": PLAN, "cell_name": CELL, "items_path": ITEMS},
    "make-order": {},
    "make-pallet-order": {},
    "plan-pallet": {"order_path": PALLET},
    "watch-zone": {"area_path": DRIVING_AREA, "watched_path": WATCHED_SCENE, "watch_name": WATCH},
    "plan-drive": {"area_path": DRIVING_AREA, "detected": DETECTED},
    "detect-pallet": {"area_path": DRIVING_AREA, "recorded": RECORDING},
    "try-grasp": {"hand_name": HAND},
    "make-stream": {"cell_name": CELL},
    "make-scene": {"order_path": ORDER, "cell_name": CELL, "items_path": ITEMS},
    "perceive": {
        "scene_path": SCENE, "cell_name": CELL, "items_path": ITEMS, "pod_path": PERCEIVED,
        "order_path": ORDER, "recorded": RECORDING,
    },
    "show-routes": {"scene_path": SCENE, "cell_name": CELL, "items_path": ITEMS, "order_path": ORDER},
    "locate-pod": {"scene_path": SCENE, "cell_name": CELL, "items_path": ITEMS, "recorded": PICTURE},
    "locate-tote": {"cell_name": CELL, "roadmap": STORE, "trajectories": STORE},
    "believe": {"paths": PERCEIVED, "cell_name": CELL, "items_path": ITEMS, "tote_path": TOTE},
    "render": {"scene_path": SCENE, "cell_name": CELL, "items_path": ITEMS},
    "plan-pick": {
        "scene_path": SCENE, "cell_name": CELL, "items_path": ITEMS, "roadmap": STORE, "trajectories": STORE,
        "stream_path": STREAM, "grasps_path": GRASPS,
    },
    "plan-move": {
        "scene_path": SCENE, "cell_name": CELL, "items_path": ITEMS, "roadmap": STORE, "trajectories": STORE,
    },
    "plan-stow": {
        "scene_path": SCENE, "cell_name": CELL, "items_path": ITEMS, "roadmap": STORE, "trajectories": STORE,
    },
    "plan-shift": {
        "scene_path": SCENE, "cell_name": CELL, "items_path": ITEMS, "roadmap": STORE, "trajectories": STORE,
    },
    "plan-topple": {
        "scene_path": SCENE, "cell_name": CELL, "items_path": ITEMS, "roadmap": STORE, "trajectories": STORE,
    },
    "explain-stow": {"order_path": ORDER, "cell_name": CELL, "items_path": ITEMS},
    "verify": {
        "plan_path": PLAN, "scene_path": SCENE, "cell_name": CELL, "items_path": ITEMS, "stopped_path": PLAN,
        "stream_path": STREAM, "order_path": PALLET, "area_path": DRIVING_AREA,
        "detected": DETECTED,
    },
    "execute": {
        "plan_path": PLAN, "scene_path": SCENE, "cell_name": CELL, "items_path": ITEMS, "planned_in": SCENE,
        "reality_path": REALITY, "roadmap": STORE, "trajectories": STORE, "stream_path": STREAM,
    },
    "run-trial": {
        "order_path": ORDER, "reality_path": REALITY, "cell_name": CELL, "items_path": ITEMS,
        "roadmap": STORE, "trajectories": STORE, "strategy_name": STRATEGY, "grasps_path": GRASPS,
    },
    "run-trials": {
        "order_paths": ORDER, "reality_path": REALITY, "cell_name": CELL, "items_path": ITEMS,
        "roadmap": STORE, "trajectories": STORE, "strategy_name": STRATEGY, "grasps_path": GRASPS,
    },
    "compare-trials": {"first": TRIALS, "second": TRIALS},
    "export": {
        "plan_path": PLAN, "scene_path": SCENE, "cell_name": CELL, "items_path": ITEMS, "stream_path": STREAM,
    },
    "check-driver": {"plan_path": PLAN, "scene_path": SCENE, "cell_name": CELL, "items_path": ITEMS},
    "check": {"path": STORE, "cell_name": CELL, "items_path": ITEMS},
    "refresh": {"path": STORE, "cell_name": CELL},
    "cache": {},
    "show-strategy": {"strategy_name": STRATEGY},
    "roll-out": {"stack_name": STACK, "scene_path": SCENE, "cell_name": CELL, "items_path": ITEMS},
    "show-grasps": {"cell_name": CELL, "items_path": ITEMS},
    "show-envelope": {"scene_path": SCENE, "cell_name": CELL, "items_path": ITEMS},
    "import-tsr": {"path": TSRS, "items_path": ITEMS},
    "inspect": {"path": None, "cell_name": CELL, "items_path": ITEMS},
    "show": {
        "path": None, "scene_path": SCENE, "cell_name": CELL, "items_path": ITEMS, "stream_path": STREAM,
    },
}  # fmt: skip
WRITTEN = (
    "output",
    "depth_path",
    "recording_path",
    "folder",
    "picture",
    "picture_path",
    "perceived",
    "video",
)  # and are told apart by refuse_output
ALSO_READ = {  # besides what the table names
    ("show", "path", TRIAL), ("inspect", "path", PERCEIVED), ("inspect", "path", STREAM),
    ("show", "path", STACKED), ("inspect", "path", STACKED), ("inspect", "path", PALLET),
    ("run-trial", "order_path", STREAM), ("run-trial", "order_path", PALLET),
    ("run-trial", "order_path", STACKED), ("run-trial", "order_path", COMMISSION),
    ("run-trials", "order_paths", COMMISSION), ("run-trials", "order_paths", STREAM),
    ("locate-pod", "recorded", RECORDING),
    ("verify", "plan_path", STACKED), ("verify", "plan_path", DRIVE),
}  # fmt: skip
# But where a file is damaged; and of streams, whose orders these are not.
UNREAD = {("check", "cell_name"), ("run-trial", "grasps_path"), ("run-trials", "grasps_path")}
CHECKED = (
    STORE,
    CELL,
    SCENE,
    ORDER,
    ITEMS,
    PERCEIVED,
    STREAM,
    PALLET,
    COMMISSION,
    DRIVING_AREA,
)  # by apc check
IN_TOTE = "in_tote.json"  # a scene with the item in the tote, beside the other files
SHOWN = (STORE, PLAN, SCENE, CELL)  # by apc inspect and apc show, which shows trials too


def _parameters(command: str) -> dict[str, click.Parameter]:
    found = cli.apc.get_command(click.Context(cli.apc), command)
    assert found is not None
    return {str(parameter.name): parameter for parameter in found.params}


@pytest.fixture(scope="module")
def files(made: Made, tmp_path_factory: pytest.TempPathFactory) -> dict[FileKind, Path]:
    """A right file of every kind."""
    folder, cell = tmp_path_factory.mktemp("kinds"), load_cell("apc2016_delft")
    found = {kind: folder / f"file_{i}" for i, kind in enumerate(KINDS)}
    write_roadmap(
        found[STORE], Roadmap.empty(cell.robot.joint_names), cell.fingerprint,
        {"by": {}, "settings": {}, "result": {}},
    )  # fmt: skip
    found[REALITY].write_text("format: apc reality\nversion: 1\n")
    found[PERCEIVED].write_text('{"format": "apc perceived", "version": 1}\n')
    found[TOTE].write_text('{"format": "apc tote", "version": 1}\n')
    found[RECORDING].write_text('{"format": "apc recording", "version": 1}\n')
    found[TRIAL].write_text('{\n  "score": 10,\n  "max_score": 20\n}\n')
    found[JOINT_LIMITS].write_text("joint_limits:\n  joint_s: {}\n")
    found[SRDF].write_text('<robot name="arm">\n  <disable_collisions link1="a" link2="b"/>\n</robot>\n')
    assert apc("make-scene", "--in", f"tote={ITEM}", "-o", folder / IN_TOTE).code == 0
    assert apc("make-stream", "--items", 1, "-o", found[STREAM]).code == 0
    assert apc("make-pallet-order", "--cartons", 1, "-o", found[PALLET]).code == 0
    found[DRIVING_AREA].write_text(
        "format: apc driving area\nversion: 1\nwalls: {low: [0, 0], high: [5, 5]}\n"
        "start: {position: [1, 1], yaw: 0}\ngoal: {position: [2, 1], yaw: 0}\n"
    )
    found[DRIVE].write_text('{"format": "apc drive", "version": 1}\n')
    found[WATCHED_SCENE].write_text("format: apc watched scene\nversion: 1\n")
    found[WATCHED_DRIVE].write_text('{"format": "apc watched drive", "version": 1}\n')
    found[DETECTED].write_text('{"format": "apc detected pallet", "version": 1}\n')
    found[GRASPS].write_text('{"format": "apc grasps", "version": 1}\n')
    found[STACKED].write_text('{"format": "apc stacked pallet", "version": 1}\n')
    tsrs = folder / "regions.tsrs"
    tsrs.write_text("- !BoxTSR\n  extents: [[0, 0], [0, 0], [0, 0], [0, 0], [0, 0], [0, 0]]\n")
    return found | {
        PLAN: made.plan, SCENE: made.scene, ORDER: made.order, CELL: cell.path / "cell.yaml",
        ITEMS: data_path() / "items" / "apc2016.yaml", URDF: cell.robot.urdf, TRIALS: folder,
        TSRS: tsrs, STRATEGY: data_path() / "strategies" / "delft.yaml",
        STACK: data_path() / "stacks" / "grasp.yaml", HAND: data_path() / "hands" / "apple.yaml",
        SENSOR: data_path() / "sensors" / "carmine.yaml",
        WATCH: data_path() / "watches" / "citi_truck.yaml",
        COMMISSION: data_path() / "tasks" / "apple_commission.json",
    }  # fmt: skip


def _call(command: str, name: str, given: Path, files: dict[FileKind, Path], out: Path) -> list[object]:
    """A right call of a command but for one file."""
    right: dict[str, object] = {
        "bin_name": "bin_C", "item": ITEM, "start": "home", "goal": "bin_C", "output": out,
        "folder": out, "format_name": "joint-trajectory", "item_name": ITEM, "by": "0,20",
    }  # fmt: skip
    argv: list[object] = [command]
    if command == "check-driver":
        right["driver_name"] = "recorder"
    if command == "check" and name == "items_path":  # stores know no items
        right["path"] = files[SCENE]
    if command == "record-grasp":
        right |= {"item": None} if name == "plan_path" else {"grasp": "0,0,20,180,0,0"}
    if command == "plan-stow":
        right["scene_path"] = files[TRIALS] / IN_TOTE
    needed = {"scene_path", "urdf"} - ({"scene_path"} if name == "stream_path" else set())
    right |= {"now": 5, "bin_name": None} if name == "stream_path" else {}
    if (command, name) == ("verify", "order_path"):  # of a stacked pallet, which stands in no scene
        right["plan_path"], needed = files[STACKED], needed - {"scene_path"}
    if command == "verify" and name in ("area_path", "detected"):  # of a drive, which stands in no scene
        right["plan_path"], needed = files[DRIVE], needed - {"scene_path"}
        right |= {"area_path": files[DRIVING_AREA]} if name == "detected" else {}
    if command == "try-grasp":
        right["object_name"] = "can"
    if command == "roll-out":
        right |= {"item_name": ITEM, "output": out.with_suffix(".csv")}
    if command in ("show-envelope", "show-grasps"):
        right["output"] = out.with_suffix(".html")
    if command == "render":
        right |= {"name": "hand", "output": out.with_suffix(".png")}
    if command == "locate-tote":
        right["output"] = out.with_suffix(".json")
    if command in ("perceive", "locate-pod"):
        right |= {"output": out.with_suffix(".json")}
        right |= {} if (command, name) == ("perceive", "recorded") else {"name": "hand", "at": "cam_C"}
    if command == "show-routes":
        right |= {"name": "hand", "at": "cam_C"}
    if command == "import-tsr":
        right["output"] = out.with_suffix(".yaml")
    if command in ("run-trial", "run-trials"):
        right["perception"] = "noise"  # else what cameras see of all bins is looked at first
    if command == "show-strategy":
        right["output"] = out.with_suffix(".svg")
    if command == "show":
        needed -= {"scene_path"} if name == "path" else set()  # only a plan is shown in a scene
        right["output"] = out.with_suffix(".html")
    if command == "execute":  # a planner is needed only for the way to where the plan begins
        right["start"] = "tote"
        argv += ["--bridge"] if name != "stream_path" else []
    for parameter in _parameters(command).values():
        kind = READ[command].get(str(parameter.name))
        is_argument = isinstance(parameter, click.Argument)
        value = right.get(str(parameter.name))
        if parameter.name == name:
            value = given
        elif value is None and (is_argument or parameter.name in needed):
            value = files[kind or (PLAN if command == "show" else SCENE)]
        if value is not None:
            argv += [value] if is_argument else [parameter.opts[-1], value]
    return argv


def test_the_table_names_every_file_that_a_command_reads() -> None:
    assert set(READ) == set(cli.COMMANDS)
    for command, read in READ.items():
        parameters = _parameters(command).values()
        paths = {
            p.name
            for p in parameters
            if isinstance(p.type, click.Path)
            or p.name in ("cell_name", "strategy_name", "stack_name", "watch_name", "hand_name")
        }
        assert paths - set(WRITTEN) == set(read), command


@pytest.mark.parametrize(
    ("command", "name"),
    [(command, name) for command, read in READ.items() for name in read if (command, name) not in UNREAD],
)
def test_every_other_kind_is_refused_in_one_line(
    command: str, name: str, files: dict[FileKind, Path], out: Path
) -> None:
    wanted = READ[command][name]
    for kind in KINDS:
        if kind in (CHECKED if command == "check" else (wanted,) if wanted is not None else SHOWN):
            continue
        if (command, name, kind) in ALSO_READ:
            continue
        answer = apc(*_call(command, name, files[kind], files, out))
        refused(answer, 3, f"{files[kind]}: is {kind.name}, but", "is expected here")
        assert wanted is None or wanted.name in answer.err
        assert answer.err.strip().count("\n") == 0
        assert not out.exists()


@pytest.mark.parametrize("magic", [b"\x89PNG\r\n\x1a\n", b"GIF89a", b"\xff\xd8\xff\xe0"])
def test_a_picture_is_called_one_wherever_it_is_handed_in(magic: bytes, made: Made, tmp_path: Path) -> None:
    picture, out = tmp_path / "file", tmp_path / "out.json"
    picture.write_bytes(magic + bytes(range(256)) * 4)
    move = ("plan-move", "--from", "home", "--to", "bin_C", "-o", out, "--scene")
    calls: list[tuple[tuple[object, ...], str]] = [
        ((*move, made.scene, "--roadmap", picture), "a roadmap"),
        ((*move, made.scene, "--trajectories", picture), "trajectory database"),
        (("check", picture, "--repair"), "a roadmap"), (("inspect", picture), "a roadmap"),
        ((*move, picture), "a scene"), (("verify", picture, "--scene", made.scene), "a plan"),
        (("make-scene", picture, "-o", out), "an order"),
    ]  # fmt: skip
    for argv, wanted in calls:
        refused(apc(*argv), 3, picture, "is a picture, but ", wanted, "is expected here")
    picture.write_bytes(b"\x7fELF\xff\x00")
    for argv, wanted in calls[4:]:
        refused(apc(*argv), 3, picture, "is a binary file, but ", wanted, "is expected here")
