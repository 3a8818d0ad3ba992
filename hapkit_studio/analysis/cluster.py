"""A Dask cluster as an executor of sweeps, on machines that run the studio's version with ``dask worker``.

Workers may join and leave. The scheduler reassigns a lost worker's chunks. After ``allowed-failures`` losses
of a chunk, the scheduler gives up, and the sweep submits the chunk again.
"""

import contextlib
import logging
import math
import socket
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future
from contextlib import contextmanager
from typing import Any

from hapkit_studio.errors import StudioError
from hapkit_studio.version import __version__

COUNT_SECONDS = 1.0
CONNECT_SECONDS = 5.0
WORKER_SECONDS = 10.0
_DASK = "distributed"


class ClusterError(StudioError):
    """A cluster cannot be used; the message contains the reason and the remedy."""


class ClusterExecutor(Executor):
    """A Dask client's executor; ``lost`` are the exceptions that mean that a chunk was lost."""

    def __init__(self, client: Any, lost: tuple[type[BaseException], ...]):
        self.client, self.lost = client, lost
        self._inner = client.get_executor(pure=False)
        self._counted, self._counted_at = 0, -math.inf

    def submit(self, fn: Callable, /, *args: Any, **kwargs: Any) -> Future:
        """Submit a call to the scheduler; return its future."""
        return self._inner.submit(fn, *args, **kwargs)

    @property
    def _max_workers(self) -> int:
        """Return the number of the workers' threads, refreshed when older than a second."""
        now = time.monotonic()
        if now - self._counted_at > COUNT_SECONDS:
            self._counted_at = now
            with contextlib.suppress(OSError, TimeoutError):  # the client reconnects by itself
                self._counted = sum(self.client.ncores().values())
        return self._counted


@contextmanager
def cluster(address: str, timeout: float = CONNECT_SECONDS) -> Iterator[Executor]:
    """Yield an executor on the Dask scheduler at an address such as tcp://host:8786.

    Raise ClusterError if no scheduler answers, or if a worker has a different version of the studio.
    """
    try:
        import distributed
    except ImportError:
        raise ClusterError(
            'A cluster needs Dask, which is not installed: pip install "hapkit-studio[cluster]".'
        ) from None
    with _dask_errors_suppressed(), _connected(distributed, address, timeout) as client:
        _check_workers(client, address)
        yield ClusterExecutor(client, (distributed.scheduler.KilledWorker,))


@contextmanager
def _dask_errors_suppressed() -> Iterator[None]:
    """Suppress Dask's tracebacks, because errors are reported in one line."""
    loggers = [logging.getLogger(name) for name in logging.root.manager.loggerDict if name.startswith(_DASK)]
    for logger in loggers:
        logger.disabled = True
    try:
        yield
    finally:
        for logger in loggers:
            logger.disabled = False


def _connected(distributed: Any, address: str, timeout: float) -> Any:
    """Return a client; check the port first, because a client without a scheduler cannot even be closed."""
    security = distributed.Security().get_connection_args("client")
    if address.startswith("tls://") and security["ssl_context"] is None:
        raise ClusterError(f"{address} needs certificates: name them in Dask's distributed.comm.tls.")
    try:
        place = distributed.comm.get_address_host_port(address)
        socket.create_connection(place, timeout).close()
        return distributed.Client(address, timeout=timeout, set_as_default=False)
    except (OSError, ValueError) as error:
        raise ClusterError(
            f"No Dask scheduler answers at {address}: start one with dask scheduler, and give its address as "
            "tcp://host:8786."
        ) from error


def _check_workers(client: Any, address: str) -> None:
    """Raise ClusterError if no worker is connected, or if a worker has a different version of the studio."""
    try:
        client.wait_for_workers(1, timeout=WORKER_SECONDS)
    except TimeoutError:
        raise ClusterError(
            f"The Dask scheduler at {address} has no workers: start some with dask worker {address}."
        ) from None
    here = studio_version()
    for worker, there in client.run(studio_version, on_error="return").items():
        if there != here:
            found = "none" if isinstance(there, BaseException) else there
            raise ClusterError(
                f"The worker {worker} needs Hapkit Studio {here}, it has {found}: install it there."
            )


def studio_version() -> str:
    """Return the version of the studio; called on the workers."""
    return __version__
