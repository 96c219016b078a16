"""Connection to a Dask scheduler."""

from __future__ import annotations

import logging
import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from pickcli.errors import InputError


@contextmanager
def connected(address: str, timeout: float) -> Iterator[Any]:
    """Connect to a Dask scheduler; closing the connection cancels the tasks that only it needs.

    Args:
        address: Address of the scheduler, e.g. tcp://host:8786.
        timeout: s to wait for the scheduler.

    Yields:
        A ``distributed.Client``.

    Raises:
        InputError: If the address is invalid, Dask is not installed, certificates are missing, or no
            scheduler answers.
    """
    if not re.fullmatch(r"(tcp|tls)://\S+:\d+", address):
        raise InputError(f"{address!r}: not a scheduler's address; name one like tcp://host:8786")
    try:
        from distributed import Client, Security
    except ImportError as error:
        raise InputError(
            f"{address}: needs Dask ({error}); install the extra: pip install 'apc-pick[cluster]'"
        ) from None
    if address.startswith("tls") and not Security().get_connection_args("client").get("ssl_context"):
        raise InputError(f"{address}: needs certificates; set distributed.comm.tls in Dask's configuration")
    with _quiet():
        try:
            client = Client(address, timeout=timeout, set_as_default=False)
        except (OSError, ValueError, TypeError) as error:
            raise InputError(
                f"{address}: no scheduler answers ({error}); start one with dask scheduler, or name another"
            ) from None
        try:
            yield client
        finally:
            client.close(timeout=timeout)


@contextmanager
def _quiet() -> Iterator[None]:
    """Silence Dask's logs: the errors raised here contain the same information in short."""
    names = [name for name in logging.root.manager.loggerDict if name.startswith(("distributed", "tornado"))]
    loud = [logger for logger in map(logging.getLogger, names) if not logger.disabled]
    for logger in loud:
        logger.disabled = True
    try:
        yield
    finally:
        for logger in loud:
            logger.disabled = False
