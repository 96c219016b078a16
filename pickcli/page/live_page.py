"""Serves the page of a running trial on this machine, at 127.0.0.1 only.

The page is made when a browser asks for it, so a trial that nobody watches loses no time. A small script in
it asks for the number of attempts every second, offers to load newer ones, and says when the trial has ended.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from types import TracebackType
from typing import Self

from pickcli.errors import InputError

HOST = "127.0.0.1"
NAMES = (HOST, "localhost")  # other names in a request's Host are refused: DNS rebinding
LAST_FETCH = 3.0  # s that the end waits for a browser that watches to load the last state
WATCHING = 3.0  # s since the last request within which a browser counts as watching
WAITING_PAGE = b"""<!doctype html>
<html lang="en"><head><meta charset="utf-8"><link rel="icon" href="data:,"><title>trial</title></head>
<body><p style="font-family: sans-serif; margin: 3em">The trial is running; its page appears after the first
attempt.</p></body></html>
"""
_SCRIPT = """<script>
(() => {
  const shown = VERSION, banner = document.createElement("button");
  banner.id = "live";
  banner.style.cssText = "position:fixed;top:8px;left:50%;transform:translateX(-50%);z-index:9;" +
    "padding:6px 12px;font:14px sans-serif;border-radius:6px;border:1px solid #888;display:none";
  banner.onclick = () => location.reload();
  document.body.append(banner);
  const say = (text) => { banner.textContent = text; banner.style.display = "block"; };
  const ask = async () => {
    try {
      const [now, isOver] = await (await fetch("version", { cache: "no-store" })).json();
      if (now > shown && (shown === 0 || isOver)) { location.reload(); return; }
      if (now > shown) say(`${now} attempts so far: show them`);
      setTimeout(ask, 1000);
    } catch { say("the trial has ended; apc show makes a page of its folder"); banner.onclick = null; }
  };
  setTimeout(ask, 1000);
})();
</script>
</body>"""


class LivePage:
    """Server of a running trial's page; a context manager that ends it.

    Args:
        port: Port of the server; 0 for a free one.

    Raises:
        InputError: The port cannot be used.
    """

    def __init__(self, port: int = 0) -> None:
        self._lock = threading.Lock()
        self._version, self._is_over = 0, False
        self._make: Callable[[], bytes] | None = None
        self._made: tuple[int, bytes] = (0, WAITING_PAGE)
        self._asked, self._fetched = -WATCHING, 0  # monotonic s of the last request; last version delivered
        try:
            self._server = ThreadingHTTPServer((HOST, port), _handler(self))
        except (OSError, OverflowError) as error:
            cause = getattr(error, "strerror", None) or str(error)
            advice = "name another port, or none for a free one"
            raise InputError(f"--live-port {port}: {cause}; {advice}") from None
        self._server.daemon_threads = True
        threading.Thread(target=self._server.serve_forever, name="live page", daemon=True).start()

    @property
    def url(self) -> str:
        """Address of the page."""
        return f"http://{HOST}:{self._server.server_port}/"

    def update(self, make: Callable[[], bytes]) -> None:
        """Offer a new state of the trial.

        Args:
            make: Makes its page; called in another thread when a browser asks, at most once.
        """
        with self._lock:
            self._version += 1
            self._make = make

    def version(self) -> tuple[int, bool]:
        """Return the number of updates so far, and whether there will be no more."""
        self._asked = time.monotonic()
        return self._version, self._is_over

    def page(self) -> bytes:
        """Return the page of the last state, with the script that watches for newer ones."""
        self._asked = time.monotonic()
        with self._lock:
            if self._make is not None:
                self._made, self._make = (self._version, self._make()), None
            version, content = self._made
        self._fetched = version
        script = _SCRIPT.replace("VERSION", str(version)).encode()
        head, _, tail = content.rpartition(b"</body>")
        return head + script + tail

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End the server; a browser that watches may first load the last state."""
        self._is_over = True
        end = time.monotonic() + LAST_FETCH
        while error is None and self._fetched < self._version and time.monotonic() < end:
            if time.monotonic() - self._asked > WATCHING:
                break
            time.sleep(0.05)
        self._server.shutdown()
        self._server.server_close()


def _handler(page: LivePage) -> type[BaseHTTPRequestHandler]:
    """Handler of the requests for a page."""

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            name = (self.headers.get("Host") or "").rpartition(":")[0] or self.headers.get("Host") or ""
            if name not in NAMES:
                self.send_error(HTTPStatus.FORBIDDEN)
            elif self.path == "/":
                self._send(page.page(), "text/html; charset=utf-8")
            elif self.path == "/version":
                version, is_over = page.version()
                self._send(f"[{version}, {str(is_over).lower()}]".encode(), "application/json")
            else:
                self.send_error(HTTPStatus.NOT_FOUND)

        def _send(self, content: bytes, kind: str) -> None:
            self.send_response(HTTPStatus.OK)
            self.send_header("Content-Type", kind)
            self.send_header("Content-Length", str(len(content)))
            self.send_header("Cache-Control", "no-store")
            self.end_headers()
            self.wfile.write(content)

        def log_message(self, format: str, *args: object) -> None:
            """Print nothing: the terminal shows the trial."""

    return Handler
