"""Options --verbose and --debug: log files read and written, and times of stages, on stderr."""

from __future__ import annotations

import logging
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from typing import TYPE_CHECKING, TextIO

import click

from pickcli.errors import printable

if TYPE_CHECKING:
    from rich.console import Console

NAME = "pickcli"  # logger that is the parent of all loggers of the package
_log = logging.getLogger(__name__)


def log_options() -> list[click.Parameter]:
    """Make the options --verbose and --debug, which every command takes.

    Returns:
        The options.
    """
    return [
        click.Option(
            ["-v", "--verbose"], is_flag=True, is_eager=True, expose_value=False, callback=_verbose,
            help="Log on stderr which files are read and written, and how long each stage takes.",
        ),
        click.Option(
            ["--debug"], is_flag=True, is_eager=True, expose_value=False, callback=_debug,
            help="As --verbose, with every detail, and the traceback of an error.",
        ),
    ]  # fmt: skip


def _verbose(_: click.Context, __: click.Parameter, is_on: bool) -> None:
    if is_on:
        show(logging.INFO)


def _debug(_: click.Context, __: click.Parameter, is_on: bool) -> None:
    if is_on:
        show(logging.DEBUG)


def show(level: int) -> None:
    """Print log messages on stderr; a lower level that was set before is kept.

    Args:
        level: Lowest level of ``logging`` that is printed.
    """
    logger = logging.getLogger(NAME)
    if not any(not isinstance(handler, _Warnings) for handler in logger.handlers):
        logger.addHandler(_handler())
        logger.setLevel(level)
        logger.propagate = False
    logger.setLevel(min(level, logger.level))


def show_warnings() -> None:
    """Print warnings on stderr like errors, each once, whether or not other messages are printed."""
    logger = logging.getLogger(NAME)
    logger.addHandler(_Warnings(logging.WARNING))
    logger.propagate = False


class _Warnings(logging.Handler):
    """Handler that prints each warning once, on its own line."""

    def __init__(self, level: int) -> None:
        super().__init__(level)
        self._printed: set[str] = set()

    def emit(self, record: logging.LogRecord) -> None:
        """Print a warning that was not printed before.

        Args:
            record: The warning.
        """
        text = record.getMessage()
        if text not in self._printed:
            self._printed.add(text)
            click.echo(f"apc: warning: {printable(text)}", err=True)


def stderr_console() -> Console:
    """Return the console of progress and logs: shared, so that log lines appear above a bar, not within it.

    Returns:
        The console on stderr.
    """
    return _console_of(sys.stderr)


@lru_cache(maxsize=1)
def _console_of(stream: TextIO) -> Console:
    from rich.console import Console

    return Console(file=stream)


def _handler() -> logging.Handler:
    """Make the handler of all messages except warnings: columns on a terminal, else one line per message."""
    handler: logging.Handler
    if sys.stderr.isatty():
        from rich.logging import RichHandler

        handler = RichHandler(console=stderr_console(), show_path=False)
    else:
        handler = logging.StreamHandler(sys.stderr)
        handler.setFormatter(logging.Formatter("%(asctime)s %(levelname)s %(name)s: %(message)s"))
    handler.addFilter(lambda record: record.levelno < logging.WARNING)
    return handler


def hide() -> None:
    """Remove all handlers, as before the first ``show``."""
    logger = logging.getLogger(NAME)
    logger.handlers.clear()
    logger.setLevel(logging.NOTSET)
    logger.propagate = True


@contextmanager
def stage(what: str) -> Iterator[None]:
    """Log how long a stage takes, also if it fails.

    Args:
        what: A noun, e.g. "verification".

    Yields:
        Nothing, once; the body is timed.
    """
    _log.debug("%s begins", what)
    began = time.perf_counter()
    try:
        yield
    finally:
        _log.info("%s took %.3f s", what, time.perf_counter() - began)
