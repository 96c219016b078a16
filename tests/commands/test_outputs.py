"""What is written never takes the place of what is read, nor of another file that is written."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest

from pickcli.commands.options.common_options import refuse_reading
from pickcli.errors import InputError
from pickcli.files import atomic_write
from pickcli.trial.trial_folder import NAMES
from support.command_line import Made, apc, refused


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("option", ["", "--reality", "--roadmap", "--trajectories"])
def test_a_trial_replaces_nothing_that_it_reads(option: str, name: str, made: Made, tmp_path: Path) -> None:
    read = tmp_path / name
    shutil.copy(made.order, read)
    if option == "--reality":
        read.write_text('{"format": "apc reality", "version": 1}')
    argv = ("run-trial", made.order, option, read) if option else ("run-trial", read)
    before = read.read_bytes()
    refused(apc(*argv, "-o", tmp_path, "--overwrite"), 3, read, "is an input of this command")
    assert [p.name for p in tmp_path.iterdir()] == [name] and read.read_bytes() == before


def test_links_in_the_folder_of_a_trial_are_looked_through(made: Made, tmp_path: Path) -> None:
    order, folder = tmp_path / "order.json", tmp_path / "runs"
    shutil.copy(made.order, order)
    folder.mkdir()
    (folder / "scene.json").symlink_to(order)
    before = order.read_bytes()
    answer = apc("run-trial", order, "-o", folder, "--overwrite")
    refused(answer, 3, folder / "scene.json", "is an input of this command")
    assert order.read_bytes() == before


def test_a_scene_and_its_picture_are_two_files(made: Made, tmp_path: Path) -> None:
    scene, folder, link = tmp_path / "new.json", tmp_path / "folder", tmp_path / "link.png"
    folder.symlink_to(tmp_path)
    link.symlink_to(scene)  # of what is not there yet
    for picture in (scene, folder / "new.json", link):
        for more in ((), ("--overwrite",)):
            argv = ("make-scene", made.order, "-o", scene, "--picture", picture)
            refused(apc(*argv, *more), 3, picture, "would be written twice")
            assert not scene.exists()


def test_no_two_files_of_a_trial_are_one(made: Made, tmp_path: Path) -> None:
    (tmp_path / "after.json").symlink_to("scene.json")
    answer = apc("run-trial", made.order, "-o", tmp_path, "--overwrite")
    refused(answer, 3, tmp_path / "after.json", "would be written twice")


WRITERS: dict[str, tuple[object, ...]] = {
    "make-order": ("make-order", "-o"),
    "make-scene": ("make-scene", "order", "-o"),
    "make-scene --picture": ("make-scene", "order", "-o", "fresh", "--picture"),
    "plan-move": ("plan-move", "--scene", "scene", "--from", "home", "--to", "bin_C", "-o"),
    "execute": ("execute", "move", "--scene", "scene", "--video"),
}


@pytest.mark.parametrize("name", WRITERS)
def test_what_another_command_writes_meanwhile_stays(
    name: str, made: Made, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out, put = tmp_path / f"out.{'png' if 'picture' in name else 'gif'}", atomic_write._put

    def put_second(path: Path, content: bytes, replace: bool) -> None:
        if path == out:
            out.write_bytes(b"theirs")
        put(path, content, replace)

    monkeypatch.setattr(atomic_write, "_put", put_second)
    files = {**vars(made), "fresh": tmp_path / "fresh.json"}
    argv = [files.get(str(word), word) for word in WRITERS[name]]
    answer = apc(*argv, out)
    assert answer.code == 3 and answer.err.count("error:") == 1
    assert f"{out}: exists by now, written by another command meanwhile" in answer.err
    assert out.read_bytes() == b"theirs"


def test_of_a_folder_that_is_no_cell_only_what_is_near_its_top_is_looked_at(tmp_path: Path) -> None:
    """So that nobody waits for a walk through a whole disk."""
    folder, output = tmp_path / "runs", tmp_path / "page.html"
    far, near = folder / "a" / "b" / "c.yaml", folder / "a" / "c.yaml"
    far.parent.mkdir(parents=True)
    output.write_text("mine")
    far.hardlink_to(output)
    refuse_reading(output, folder)
    near.hardlink_to(output)
    with pytest.raises(InputError, match=re.escape(f"is an input of this command ({near})")):
        refuse_reading(output, folder)
    near.unlink()
    (folder / "cell.yaml").write_text("format: apc cell\n")
    with pytest.raises(InputError, match=re.escape(f"is an input of this command ({far})")):
        refuse_reading(output, folder)
