"""Pages in headless Chromium: they open fast, fail nowhere, ask the network for nothing, can be used."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from pickcli.page.html_page import page_bytes
from pickcli.page.page_document import PageDocument
from pickcli.page.plan_page import plan_page
from pickcli.page.scene_page import cell_page, scene_page
from support.browser import Browser, browser
from support.handmade_plans import CRAYOLA, pick, pick_pushing

pytestmark = pytest.mark.slow

FIRST_FRAME = 1000.0  # ms
TRIES = 20  # the machine may be busy: a page is as fast as it ever was


@pytest.fixture(scope="module")
def opened(chromium: str, tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Browser, Path]]:
    path = tmp_path_factory.mktemp("pages") / "plan.html"
    path.write_bytes(page_bytes(plan_page(*pick())))
    with browser(chromium) as found:
        yield found, path


@pytest.fixture
def plan(opened: tuple[Browser, Path]) -> Iterator[Browser]:
    found, path = opened
    found.open(path)
    found.until("apcPage.path.line")  # what is drawn after the first frame
    yield found
    assert found.errors == []
    assert set(found.requests) == {path.resolve().as_uri()}


def test_the_first_frame_is_there_within_a_second(opened: tuple[Browser, Path]) -> None:
    found, path = opened
    times = []
    for _ in range(TRIES):
        found.open(path)
        times.append(found.run("apcPage.firstFrame"))
        if times[-1] < FIRST_FRAME:
            break
    assert min(times) < FIRST_FRAME


def test_it_plays_pauses_and_ends(plan: Browser) -> None:
    assert plan.run("apcPage.replay.t") == 0
    plan.press(" ")
    plan.until("apcPage.replay.t > 0.05")
    plan.press(" ")
    t = plan.run("apcPage.replay.t")
    assert plan.run("apcPage.replay.isPlaying") is False and plan.run("apcPage.replay.t") == t
    for _ in range(5):
        plan.press("ArrowUp")
    assert plan.run("apcPage.replay.speed") == 16
    plan.press("End")
    assert plan.run("apcPage.replay.t") == plan.run("apcPage.replay.duration")


def test_space_plays_whatever_was_clicked_last_and_presses_what_is_focused(plan: Browser) -> None:
    x, y = plan.run(
        "(({x, y}) => [x + 8, y + 8])("
        "document.querySelector('#toolbar button + button').getBoundingClientRect())"
    )
    plan.click(x, y)
    assert plan.run("apcPage.cameras.mode") == "follow"
    plan.press(" ")
    assert plan.run("apcPage.replay.isPlaying") is True
    plan.run("document.getElementById('play').focus()")
    plan.press(" ")
    assert plan.run("apcPage.replay.isPlaying") is False


def test_it_is_scrubbed_by_keys_and_pointer(plan: Browser) -> None:
    plan.press("ArrowRight", shift=True)
    assert plan.run("apcPage.replay.t") == pytest.approx(1.0)
    plan.press("ArrowLeft")
    assert plan.run("apcPage.replay.t") == pytest.approx(0.9)
    left, top = plan.run("(({x, y}) => [x, y])(document.getElementById('lanes').getBoundingClientRect())")
    plan.click(left + plan.run("apcPage.timeline.x(2)"), top + 30)
    assert plan.run("apcPage.replay.t") == pytest.approx(2.0, abs=0.02)
    told = plan.run("document.getElementById('tip').textContent")
    assert told.startswith("2.0") and "segments: " in told


def test_the_item_moves_with_the_tool_and_stays_where_it_is_let_go(plan: Browser) -> None:
    document, _ = plan_page(*pick()), pick()
    assert document.motion is not None
    (carried,) = document.motion.carried
    place = f"apcPage.stage.items.get('{CRAYOLA}').position.toArray()"
    lay = plan.run(place)
    plan.run(f"apcPage.replay.seek({carried.t_start - 0.01})")
    assert plan.run(place) == lay
    plan.run(f"apcPage.replay.seek({carried.t_end - 0.001})")
    held = plan.run(place)
    assert max(abs(a - b) for a, b in zip(held, lay, strict=True)) > 0.1
    plan.press("End")
    assert plan.run(place) == pytest.approx(held, abs=2e-3)


def test_a_click_tells_the_name(plan: Browser) -> None:
    plan.run(
        "globalThis.spot = () => { const p = apcPage.stage.items.get('" + CRAYOLA + "').position.clone()"
        ".project(apcPage.stage.camera); const b = document.getElementById('view').getBoundingClientRect();"
        "return [b.x + (p.x + 1) * b.width / 2, b.y + (1 - p.y) * b.height / 2]; }"
    )
    plan.press("4")
    plan.until("!apcPage.stage.isStale")
    x, y = plan.run("spot()")
    plan.move(x, y)
    assert CRAYOLA.replace("_", " ") in plan.run("document.getElementById('pointed').textContent")
    plan.click(x, y)
    assert CRAYOLA.replace("_", " ") in plan.run("document.querySelector('#panel .card').textContent")
    plan.press("Escape")
    assert plan.run("document.querySelector('#panel .card')") is None


@pytest.mark.parametrize("key", ["1", "2", "3", "4", "s", "n", "p", "l", ".", ",", "Home"])
def test_keys_do_something_or_nothing_but_never_fail(plan: Browser, key: str) -> None:
    plan.press("ArrowRight", shift=True)
    plan.press(key)
    plan.press(" ")
    plan.until("apcPage.replay.t > 1.05 || apcPage.replay.t < 0.95")


@pytest.mark.parametrize("is_dark", [False, True])
def test_pages_without_a_motion_and_rejected_plans_open_too(
    chromium: str, tmp_path: Path, is_dark: bool
) -> None:
    _, scene = pick()
    documents: dict[str, PageDocument] = {
        "cell": cell_page(scene.cell),
        "scene": scene_page(scene),
        "plan": plan_page(pick_pushing(0.05), scene),
    }  # fmt: skip
    with browser(chromium, is_dark=is_dark) as found:
        for name, document in documents.items():
            path = tmp_path / f"{name}.html"
            path.write_bytes(page_bytes(document))
            found.open(path)
        found.until("document.querySelectorAll('#labels > .bad').length")
        found.run("document.querySelector('#panel .row').click()")
        assert found.run("apcPage.replay.t") > 0
        assert found.errors == []
