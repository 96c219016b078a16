"""The page of a running trial: served to this machine only, made when asked for, ended with the trial."""

from __future__ import annotations

import http.client
import json
import threading
import time
from collections.abc import Iterator

import pytest

from pickcli.errors import InputError
from pickcli.page.live_page import LAST_FETCH, LivePage

PAGE = b"<html><body><p>state %d</p></body></html>"


@pytest.fixture
def live() -> Iterator[LivePage]:
    with LivePage() as page:
        yield page


def get(live: LivePage, path: str = "/", host: str | None = None) -> tuple[int, str]:
    port = int(live.url.rstrip("/").rpartition(":")[2])
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=5)
    connection.request("GET", path, headers={} if host is None else {"Host": host})
    answer = connection.getresponse()
    return answer.status, answer.read().decode()


def test_before_the_first_attempt_a_page_waits_for_it(live: LivePage) -> None:
    status, text = get(live)
    assert status == 200 and "after the first" in text and "const shown = 0" in text
    assert json.loads(get(live, "/version")[1]) == [0, False]


def test_a_state_is_made_once_and_only_if_a_browser_asks(live: LivePage) -> None:
    made: list[int] = []

    def state(k: int) -> bytes:
        made.append(k)
        return PAGE % k

    for k in range(1, 4):
        live.update(lambda k=k: state(k))  # type: ignore[misc]
    assert json.loads(get(live, "/version")[1]) == [3, False] and made == []
    for _ in range(2):
        status, text = get(live)
        assert status == 200 and "state 3" in text and "const shown = 3" in text and text.endswith("</html>")
    assert made == [3]


def test_other_paths_and_other_hosts_get_nothing(live: LivePage) -> None:
    assert get(live, "/trial.json")[0] == 404
    assert get(live, host="evil.example:80")[0] == 403
    assert get(live, host="localhost")[0] == get(live, host="127.0.0.1")[0] == 200


def test_a_port_that_is_taken_is_refused_in_one_line(live: LivePage) -> None:
    port = int(live.url.rstrip("/").rpartition(":")[2])
    with pytest.raises(InputError, match=rf"--live-port {port}: .*name another port"):
        LivePage(port)


def test_a_browser_that_watches_gets_the_last_state_before_the_end() -> None:
    seen: list[str] = []
    with LivePage() as live:
        get(live, "/version")

        def load() -> None:
            time.sleep(0.2)
            seen.append(get(live)[1])

        live.update(lambda: PAGE % 7)
        loading = threading.Thread(target=load)
        loading.start()
    loading.join()
    assert "state 7" in seen[0]
    with pytest.raises(OSError):
        get(live)


def test_without_a_browser_the_end_waits_for_nobody() -> None:
    began = time.monotonic()
    with LivePage() as live:
        live.update(lambda: PAGE % 1)
    assert time.monotonic() - began < LAST_FETCH / 2
