"""Work on the workers of a Dask cluster; a worker that is killed loses nothing but the task that it was at."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from importlib.util import find_spec
from typing import Any

from toolkit.foundation.errors import InputError
from toolkit.studies.engine.fingerprint import program
from toolkit.studies.engine.processes import StudyError

PATIENCE = 20
"""Seconds for which scheduler and workers are waited for."""


def on_cluster(work: Callable[[Any], Any], tasks: Mapping[Any, Any], address: str, remedy: str) -> Iterator[tuple[Any, Any]]:
    """What the work makes of each task, as it gets done.

    The work travels once to every worker, where all of its tasks share it, and what they compile. It is a task of its own: if the only
    worker that holds it is killed, the scheduler sends it to another one.

    Raises
    ------
    InputError
        Dask is not installed, or nobody answers at the address, or nobody works there.
    StudyError
        The cluster ended, or workers are killed again and again; or they run another version of the program.
    """
    if find_spec("distributed") is None:
        raise InputError(
            "--dask needs the package distributed, which is not installed. Install: pip install 'ffrf-toolkit[studies]'."
        )
    import distributed

    with _silent_logs(), _client(address) as client:
        at_hand = client.submit(arrived, work, program(), pure=False)
        futures = {client.submit(run, at_hand, task, pure=False): key for key, task in tasks.items()}
        try:
            for future in distributed.as_completed(list(futures), loop=client.loop):
                if future.status == "cancelled":
                    raise StudyError(f"the Dask cluster at {address} is gone. {remedy}")
                yield futures.pop(future), future.result()
        except (distributed.KilledWorker, distributed.client.FutureCancelledError) as error:
            raise StudyError(
                f"workers of the Dask cluster at {address} were killed again and again: {error}. {remedy}"
            ) from error
        finally:
            client.cancel(list(futures), force=True)


@contextmanager
def _silent_logs() -> Iterator[None]:
    """What Dask tells its own log about lost connections is told by this module's errors."""
    log = logging.getLogger("distributed")
    before = log.level
    log.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        log.setLevel(before)


def _client(address: str) -> Any:
    """A client of a cluster that has workers."""
    import distributed

    try:
        client = distributed.Client(address, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        raise InputError(
            f"no Dask scheduler answers at {address!r} ({type(error).__name__}). Start one with `dask scheduler`, and give the address "
            "that it prints."
        ) from error
    try:
        client.wait_for_workers(1, timeout=PATIENCE)
    except TimeoutError as error:
        client.close()
        raise InputError(
            f"the Dask scheduler at {address!r} has no workers. Start some: `dask worker {address} --nthreads 1`."
        ) from error
    return client


def arrived(work: Callable[[Any], Any], version: str) -> Callable[[Any], Any]:
    """The work on a worker, if that runs the same program."""
    if program() != version:
        raise StudyError(
            "a worker of the Dask cluster runs another version of ffrf-toolkit, whose numbers might differ. Install the same one there."
        )
    return work


def run(work: Callable[[Any], Any], task: Any) -> Any:
    """One task, on a worker."""
    return work(task)
