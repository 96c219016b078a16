"""Mistakes in a scene or an order."""

from __future__ import annotations

from typing import Any

from support.user_mistakes.mistake import Change, Mistake

PICK = "plan-pick --scene SCENE --bin bin_C --item dove_beauty_bar -o OUT"


def _scene(name: str, told: str, change: Change, code: int = 3, call: str = PICK) -> Mistake:
    return Mistake(name, call, told, code, scene=change)


def _order(name: str, told: str, change: Change, code: int = 3) -> Mistake:
    return Mistake(name, "make-scene ORDER -o OUT", told, code, order=change)


def _put(*path: Any, value: Any) -> Change:
    """Set a value; None removes its key."""

    def change(data: Any) -> None:
        for part in path[:-1]:
            data = data[part]
        if value is None:
            del data[path[-1]]
        else:
            data[path[-1]] = value

    return change


def _each(change: Change) -> Change:
    """Change every item."""
    return lambda data: [change(item) for item in data["items"]]


def _shifted(i: int, *by: float) -> Change:
    def change(data: Any) -> None:
        at = data["items"][i]["position"]
        data["items"][i]["position"] = [p + d for p, d in zip(at, by, strict=True)]

    return change


def _wxyz(item: Any) -> None:
    x, y, z, w = item["quaternion"]
    item["quaternion"] = [w, x, y, z]


def _in_mm(item: Any) -> None:
    item["position"] = [1000 * p for p in item["position"]]


def _in_pod_frame_of_bin(item: Any) -> None:
    item["position"] = [item["position"][0], 0.0, 0.05]


SCENE_MISTAKES = (
    _scene(
        "an item 0.1 m under its floor",
        "items[0].position: kleenex_tissue_box reaches … are in m, quaternions x, y, z, w)",
        _shifted(0, 0.0, 0.0, -0.1),
    ),
    _scene(
        "an item 30 mm sunk into its floor",
        "items[0].position: kleenex_tissue_box reaches … are in m, quaternions x, y, z, w)",
        _shifted(0, 0.0, 0.0, -0.03),
    ),
    _scene(
        "an item that floats 0.1 m over its floor",
        "items[0].position: kleenex_tissue_box floats: … or state in noise how far poses may be off",
        _shifted(0, 0.0, 0.0, 0.05),
    ),
    _scene(
        "an item in the wall of its bin",
        "items[0].position: kleenex_tissue_box stands … are in m, quaternions x, y, z, w)",
        _shifted(0, 0.0, 0.12, 0.0),
    ),
    _scene(
        "an item in front of its bin",
        "items[0].position: kleenex_tissue_box is 0.26 … in the world frame (docs/formats/scene.md)",
        _shifted(0, -0.6, 0.0, 0.0),
    ),
    _scene(
        "an item in the back wall",
        "items[0].position: kleenex_tissue_box is 0.20 … in the world frame (docs/formats/scene.md)",
        _shifted(0, 0.3, 0.0, 0.0),
    ),
    _scene(
        "the pod moved by 0.5 m, items left",
        "items[0].position: kleenex_tissue_box is 0.16 … in the world frame (docs/formats/scene.md)",
        _put("T_world_pod", "position", value=[0.5, 0.0, 0.0]),
    ),
    _scene(
        "the pod turned by 90 degrees",
        "items[0].position: kleenex_tissue_box is 0.49 … in the world frame (docs/formats/scene.md)",
        _put("T_world_pod", "quaternion", value=[0.0, 0.0, 0.7071068, 0.7071068]),
    ),
    _scene(
        "the pod lying down",
        "T_world_pod.quaternion: leans by 90 degrees; it stands upright … is the quaternion x, y, z, w?",
        _put("T_world_pod", "quaternion", value=[0.7071068, 0.0, 0.0, 0.7071068]),
    ),
    _scene(
        "quaternions as w, x, y, z",
        "items[1].position: staples_index_cards stands … are in m, quaternions x, y, z, w)",
        _each(_wxyz),
    ),
    _scene(
        "a quaternion of Euler angles",
        "items[0].quaternion: expected a unit … w]: at least 4 entries, got 3; correct it",
        _put("items", 0, "quaternion", value=[0.0, 0.0, 1.57]),
    ),
    _scene(
        "a quaternion in degrees",
        "items[0].quaternion[2]: expected a unit … than or equal to 2, got 90.0; correct it",
        _put("items", 0, "quaternion", value=[0.0, 0.0, 90.0, 1.0]),
    ),
    _scene(
        "a quaternion of zeros",
        "items[0].quaternion: expected a length of 1, got 0; write x, y, z, w normalised",
        _put("items", 0, "quaternion", value=[0.0, 0.0, 0.0, 0.0]),
    ),
    _scene(
        "a quaternion that is no unit",
        "items[0].quaternion: expected a length of 1, got 0.7071; write x, y, z, w normalised",
        _put("items", 0, "quaternion", value=[0.0, 0.0, 0.5, 0.5]),
    ),
    _scene(
        "positions in mm",
        "items[0].position[0]: expected a position [x, y, z] in m … lengths are in m, not mm",
        _each(_in_mm),
    ),
    _scene(
        "positions in the frame of the bin",
        "items[0].position: kleenex_tissue_box is 1.48 … in the world frame (docs/formats/scene.md)",
        _each(_in_pod_frame_of_bin),
    ),
    _scene(
        "position with two numbers",
        "items[0].position: expected a position [x, y, z] in m: at least 3 entries, got 2; correct it",
        _put("items", 0, "position", value=[0.3, 0.2]),
    ),
    _scene(
        "position as text",
        'items[0].position[0]: expected a position [x, … got "0.3"; write 0.3, without quotes',
        _put("items", 0, "position", value=["0.3", "0.2", "1.5"]),
    ),
    _scene(
        "noise in mm",
        "noise.position: expected a value in m: less … to 0.1, got 2; lengths are in m, not mm",
        _put("noise", "position", value=2),
    ),
    _scene(
        "noise of 5 cm",
        "noise.position: every item counts as 50 mm larger all around; is it in m?",
        _put("noise", "position", value=0.05),
        call="check SCENE --strict",
    ),
    _scene(
        "noise in degrees",
        "noise.angle: every item may be turned by 2 rad either way; is it in rad, not degrees?",
        _put("noise", "angle", value=2.0),
        call="check SCENE --strict",
    ),
    _scene(
        "noise of 15 degrees",
        "noise.angle: expected a value in rad: less … got 15.0; angles are in rad, not degrees",
        _put("noise", "angle", value=15.0),
    ),
    _scene(
        "noise negative",
        "noise.position: expected a value in m: greater than or equal to 0, got -0.002; correct it",
        _put("noise", "position", value=-0.002),
    ),
    _scene(
        "the pod's error in mm",
        "pod_error.x: expected a value in m: less than … to 0.1, got 2; lengths are in m, not mm",
        _put("pod_error", "x", value=2),
    ),
    _scene(
        "an unknown item",
        "items[0].name: unknown item 'kleenex_tisue_box' of 2016; did you mean 'kleenex_tissue_box'?",
        _put("items", 0, "name", value="kleenex_tisue_box"),
    ),
    _scene(
        "an item of another year",
        "items[0].name: unknown item 'kleenex_tissue_box' of 2017; there are items of 2015 and 2016",
        _put("items", 0, "year", value=2017),
    ),
    _scene(
        "an unknown place",
        "items[0].location: unknown place 'bin_Z'; … bin_H, bin_I, bin_J, bin_K, bin_L, tote",
        _put("items", 0, "location", value="bin_Z"),
    ),
    _scene(
        "a place by its letter",
        "items[0].location: unknown place 'C'; did you mean 'bin_C'?",
        _put("items", 0, "location", value="C"),
    ),
    _scene(
        "an item said to be in another bin",
        "items[0].position: kleenex_tissue_box is 0.68 … in the world frame (docs/formats/scene.md)",
        _put("items", 0, "location", value="bin_L"),
    ),
    _scene(
        "one id twice",
        "items[4].id: 'kleenex_tissue_box' stands twice; give each instance an id of its own",
        lambda data: data["items"].append(dict(data["items"][0])),
    ),
    _scene(
        "an item twice at one place",
        "items[4]: kleenex_tissue_box and again overlap by 110.0 mm; correct one of the poses",
        lambda data: data["items"].append({**data["items"][0], "id": "again"}),
    ),
    _scene(
        "a misspelt key",
        "items[0].position: expected a position [x, y, z] in m, got nothing; add it",
        lambda data: data["items"][0].update(postion=data["items"][0].pop("position")),
    ),
    _scene("no items", "items: expected the items, got nothing; add it", _put("items", value=None)),
    _scene(
        "no noise",
        "noise: expected bounds of the error of poses of items without bounds of their own, got nothing",
        _put("noise", value=None),
    ),
    _scene(
        "another cell's fingerprint",
        "scene.json: made for cell apc2016_delft …, but this is apc2016_delft …; make the scene again",
        _put("cell", "fingerprint", value="0" * 64),
        code=4,
    ),
    _scene(
        "half a fingerprint",
        'cell.fingerprint: expected the cell\'s … got "0000000000000000"; correct it',
        _put("cell", "fingerprint", value="0" * 16),
    ),
    _scene(
        "a cell that is not there",
        "cell.name: unknown cell 'apc2017'; … --cell",
        _put("cell", "name", value="apc2017"),
    ),
    _scene(
        "another version",
        "version: expected 1, the only version there is, got 2; correct it",
        _put("version", value=2),
    ),
    _scene(
        "another format",
        "format: expected 'apc scene', got \"apc scenes\"; correct it",
        _put("format", value="apc scenes"),
    ),
    _scene(
        "seed as text",
        'seed: expected the seed it was made with: a valid integer, got "three"; correct it',
        _put("seed", value="three"),
    ),
    _scene(
        "a cloud that is not there",
        "cloud.file: … points.npy: no such file; the scene names it as its cloud",
        _put(
            "cloud",
            value={"file": "points.npy", "position": [0, 0, 0], "quaternion": [0, 0, 0, 1], "radius": 0.005},
        ),
    ),
    _scene(
        "a cloud's radius in mm",
        "cloud.radius: expected m, 0.0005 to 0.1, … to 0.1, got 5; lengths are in m, not mm",
        _put(
            "cloud",
            value={"file": "points.npy", "position": [0, 0, 0], "quaternion": [0, 0, 0, 1], "radius": 5},
        ),
    ),
    _scene(
        "something held that is far from the cup",
        "held.position: the middle of x is 1 m from … origin at the tip of the cup, +z out of it",
        _put(
            "held",
            value={
                "id": "x",
                "name": "dove_beauty_bar",
                "year": 2016,
                "position": [0, 0, 1.0],
                "quaternion": [0, 0, 0, 1],
            },
        ),
    ),
    _scene(
        "something held where an empty cup is wanted",
        "scene.json: held: x is in the cup, and this … the item where it lies and plan from there",
        _put(
            "held",
            value={
                "id": "x",
                "name": "dove_beauty_bar",
                "year": 2016,
                "position": [0, 0, 0.015],
                "quaternion": [0, 0, 0, 1],
            },
        ),
    ),
    _scene(
        "an item in the tote's frame",
        "items[0].position: kleenex_tissue_box stands … are in m, quaternions x, y, z, w)",
        lambda data: data["items"][0].update(location="tote", position=[0.0, 0.0, 0.05]),
    ),
)
ORDER_MISTAKES = (
    _order(
        "an unknown item",
        "bin_contents.bin_C[0]: unknown item 'dove_beauty_barr'; did you mean 'dove_beauty_bar'?",
        _put("bin_contents", "bin_C", value=["dove_beauty_barr"]),
    ),
    _order(
        "an unknown bin",
        "bin_contents.bin_M: unknown bin; known: … bin_G, bin_H, bin_I, bin_J, bin_K, bin_L",
        _put("bin_contents", "bin_M", value=["dove_beauty_bar"]),
    ),
    _order(
        "a target that is not in its bin",
        "work_order[0].item: 'dove_beauty_bar' is … in bin_C); correct the bin or the contents",
        _put("work_order", value=[{"bin": "bin_A", "item": "dove_beauty_bar"}]),
    ),
    _order(
        "a target without a bin",
        "work_order[0].bin: expected the name of a bin, got nothing; add it",
        _put("work_order", value=[{"item": "dove_beauty_bar"}]),
    ),
    _order(
        "a bin missing",
        "bin_contents: the bin 'bin_D' is missing; add it (\"bin_D\": [] if empty)",
        _put("bin_contents", "bin_D", value=None),
    ),
    _order(
        "contents that are no list",
        'bin_contents.bin_C: expected a list [...], got "dove_beauty_bar"; correct it',
        _put("bin_contents", "bin_C", value="dove_beauty_bar"),
    ),
    _order(
        "a target twice",
        "work_order[1].item: 'dove_beauty_bar' is … holds 1; delete one target or add a copy",
        lambda data: data["work_order"].append(dict(data["work_order"][0])),
    ),
    _order(
        "a misspelt key",
        "workorder: unknown key; did you mean 'work_order'?",
        lambda data: data.update(workorder=data.pop("work_order")),
    ),
    _order(
        "contents of a name that is no text",
        "bin_contents.bin_C[0]: expected text in quotes, got 5; correct it",
        _put("bin_contents", "bin_C", value=[5]),
    ),
    _order(
        "nothing at all",
        "bin_contents: expected an object with a list of items for every bin, got nothing; add it",
        lambda data: data.clear(),
    ),
    _order(
        "most bins left out",
        'bin_contents: the bins bin_B, bin_C, … bin_L are missing; add them ("bin_B": [] if empty)',
        lambda data: data.update(bin_contents={"bin_A": data["bin_contents"]["bin_A"]}),
    ),
    _order(
        "an item of one's own",
        "unknown item 'my_gadget'; known: … (items of your own: --items)",
        lambda data: data["bin_contents"]["bin_C"].append("my_gadget"),
    ),
)
