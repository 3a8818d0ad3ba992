"""A Dask cluster as an executor of sweeps: many machines, each with the studio and ``dask worker``.

Workers may come and go: the scheduler gives a lost worker's chunks to another, and what it gives up, after
its ``allowed-failures``, the sweep sends again.
"""

import socket
from collections.abc import Iterator
from concurrent.futures import Executor
from contextlib import contextmanager
from typing import Any

from hapkit_studio.errors import StudioError

CONNECT_SECONDS = 5.0
WORKER_SECONDS = 10.0


class ClusterError(StudioError):
    """A cluster cannot be used; the text says why and what to do."""


@contextmanager
def cluster(address: str, timeout: float = CONNECT_SECONDS) -> Iterator[Executor]:
    """Give an executor on the Dask scheduler at an address such as tcp://host:8786; raise ClusterError.

    Every worker needs the same version of the studio.
    """
    distributed = _distributed()
    with _connected(distributed, address, timeout) as client:
        _check_workers(client, address)
        executor = client.get_executor(pure=False)
        executor._max_workers = sum(client.ncores().values())
        executor.lost = (distributed.scheduler.KilledWorker,)
        yield executor


def _connected(distributed: Any, address: str, timeout: float) -> Any:
    """Return a client; none is made where nobody listens: without a scheduler it could not even close."""
    try:
        place = distributed.comm.get_address_host_port(address)
        socket.create_connection(place, timeout).close()
        return distributed.Client(address, timeout=timeout, set_as_default=False)
    except (OSError, ValueError) as error:
        raise ClusterError(
            f"No Dask scheduler answered at {address} within {timeout:g} s: start one with dask scheduler, "
            "and give its address as tcp://host:8786."
        ) from error


def _distributed() -> Any:
    try:
        import distributed
    except ImportError:
        raise ClusterError(
            'A cluster needs Dask, which is not installed: pip install "hapkit-studio[cluster]".'
        ) from None
    return distributed


def _check_workers(client: Any, address: str) -> None:
    """Raise ClusterError unless there are workers and all have this version of the studio."""
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
    """Return the version of the studio where this runs."""
    import hapkit_studio

    return hapkit_studio.__version__
