"""A cluster of dask, as the one who hands out tasks sees it: so many workers, each of which takes a task at a time."""

from __future__ import annotations

import logging
import warnings
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future
from contextlib import ExitStack, contextmanager, suppress
from functools import partial
from multiprocessing import get_context
from tempfile import TemporaryDirectory
from typing import Any

from varishold._lazy import missing_extra
from varishold.corpus.content import program_digest
from varishold.corpus.tasks import CannotKeep
from varishold.errors import InputError
from varishold.files.crew import Worker, processors
from varishold.files.workers import can_share, interrupted_afterwards

__all__ = ["LOCAL", "cluster"]

#: Instead of an address: a cluster of this machine, which ends with the run.
LOCAL = "local"
# How long a scheduler may take to answer, and its first worker to be there. Seconds.
_PATIENCE_S = 10
# What its workers do beside: a tenth of their time goes into looking at themselves otherwise.
_QUIET = {
    "distributed.worker.profile.enabled": False,
    "distributed.admin.tick.interval": "1s",
    "distributed.admin.system-monitor.interval": "10s",
    "distributed.admin.system-monitor.gil.enabled": False,
}


@contextmanager
def cluster(address: str, *, number: int | None = None) -> Iterator[list[Worker]]:
    """Work on a cluster.

    Parameters
    ----------
    address : str
        Of its scheduler, as in ``tcp://host:8786``; or "local" for one of this machine, that ends with the run.
    number : int, optional
        Workers of a local one. Default: one a processor.

    Raises
    ------
    InputError
        If no scheduler answers, it has no worker, or its workers cannot run this version of the program.
    MissingExtraError
        If dask.distributed is not installed.
    """
    try:
        import distributed
        from distributed.comm.addressing import parse_address, parse_host_port
    except ModuleNotFoundError as error:
        raise missing_extra(error) from None
    with ExitStack() as stack:
        stack.enter_context(_silent())
        with interrupted_afterwards():
            # The tracker of locks is started with the first of them, and lets this thread hear Ctrl-C afterwards.
            can_share(get_context("spawn"))
        # What starts meanwhile never hears Ctrl-C.
        with interrupted_afterwards():
            known = _local(stack, number or processors()) if address == LOCAL else address
            try:
                if address != LOCAL:
                    # Before a client begins to look for it: one that fails later hangs.
                    parse_host_port(parse_address(address)[1])
                client = stack.enter_context(_begun(distributed.Client, known))
                client.wait_for_workers(1, timeout=_PATIENCE_S)
            except (OSError, ValueError, TypeError) as error:
                reason = " ".join(str(error).split()) or type(error).__name__
                raise InputError(
                    f"{address}: no cluster answers there: {reason[:200]}; name a scheduler's address, as in "
                    "tcp://host:8786, or local"
                ) from error
            _check_programs(address, client)
        yield [_Seat(client, address, each) for each in _seats(client)]


def _begun(kind: Any, known: Any) -> Any:
    """Return a client; one that fails is closed at once.

    Otherwise it closes when it is cleared away: that may be while another one begins, and each waits for the other.
    """
    client = kind.__new__(kind)
    try:
        client.__init__(known, timeout=_PATIENCE_S, set_as_default=False)
    except BaseException:
        # One that has not got as far as to have anything to close.
        with suppress(AttributeError):
            client.close()
        raise
    return client


class _Seat:
    """A thread of a worker; where that is lost, others take its tasks."""

    def __init__(self, client: Any, address: str, worker: str) -> None:
        self._address = address
        # A recording stays where it is open, as long as that is there.
        self._executor: Executor = client.get_executor(workers=[worker], allow_other_workers=True, pure=False)

    def submit(self, work: Callable[[Any], Any], task: Any) -> Future[Any]:
        told: Future[Any] = Future()
        self._executor.submit(work, task).add_done_callback(partial(_pass_on, told, self._address))
        return told


def _pass_on(told: Future[Any], address: str, done: Future[Any]) -> None:
    """Tell what became of a task, a lost cluster and dead workers by the names that all workers have."""
    from distributed import KilledWorker

    try:
        error = done.exception()
    except CancelledError as gone:
        error = gone
    if error is None:
        told.set_result(done.result())
    elif isinstance(error, KilledWorker):
        told.set_exception(BrokenExecutor(str(error)))
    elif isinstance(error, CancelledError | OSError) or type(error).__name__ == "FutureCancelledError":
        told.set_exception(CannotKeep(f"{address}: the cluster was lost; run again: what was written is kept"))
    else:
        told.set_exception(error)


def _local(stack: ExitStack, number: int) -> Any:
    import dask
    from distributed import LocalCluster

    stack.enter_context(dask.config.set(_QUIET))
    scratch = stack.enter_context(TemporaryDirectory(prefix="varishold-", ignore_cleanup_errors=True))
    made = LocalCluster(
        n_workers=number,
        threads_per_worker=1,
        memory_limit=None,
        dashboard_address=None,
        local_directory=scratch,
        silence_logs=logging.CRITICAL,
    )
    return stack.enter_context(made)


def _check_programs(address: str, client: Any) -> None:
    """Refuse workers that would answer otherwise, or not at all."""
    for worker, found in client.run(program_digest, on_error="return").items():
        if isinstance(found, BaseException):
            raise InputError(f"{address}: its worker {worker} cannot run varishold: {found}; install it there")
        if found != program_digest():
            raise InputError(f"{address}: its worker {worker} has another version of varishold; install the same there")


def _seats(client: Any) -> list[str]:
    """Return the address of each worker, once a thread."""
    return [worker for worker, threads in sorted(client.nthreads().items()) for _ in range(threads)]


@contextmanager
def _silent() -> Iterator[None]:
    """Lost workers are told by us, in one line."""
    names = [name for name in logging.root.manager.loggerDict if name.partition(".")[0] in ("distributed", "tornado")]
    levels = {name: logging.getLogger(name).level for name in names}
    for name in names:
        logging.getLogger(name).setLevel(logging.CRITICAL + 1)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        for name, level in levels.items():
            logging.getLogger(name).setLevel(level)
