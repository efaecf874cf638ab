"""Jobs through Dask: in processes of this machine, or on a cluster."""

import argparse
import contextlib
import importlib.util
import os
import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from typing import Any

from ..errors import UserError


__all__ = ["Job", "Run", "add_worker_options", "check_installed", "workers"]


Job = tuple[Any, ...]  # a function and its arguments
Done = Callable[[int, Any], object]  # takes the number of a job and its result
Run = Callable[[Sequence[Job], Done], None]


def add_worker_options(parser: argparse.ArgumentParser) -> None:
    """Add ``--workers`` and ``--scheduler``, for :func:`workers`."""
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1, metavar="N", help="processes (default: %(default)s)")
    parser.add_argument("--scheduler", metavar="ADDRESS", help="compute on the Dask cluster at tcp://HOST:PORT, not in processes here")


def check_installed(*names: str) -> None:
    """:class:`UserError` unless the packages are installed."""
    for name in names:
        if importlib.util.find_spec(name) is None:
            raise UserError(f"{name} is not installed; install the extra lab of this package")


def _local(jobs: Sequence[Job], done: Done) -> None:
    """Compute in the processes that :func:`workers` has started."""
    import dask  # here, because it takes longer to load than all the rest
    from dask.callbacks import Callback

    tasks = [dask.delayed(function, pure=False)(*arguments, dask_key_name=f"job-{number}")
             for number, (function, *arguments) in enumerate(jobs)]

    def finished(key: str, result: Any, *_: Any) -> None:
        done(int(key.removeprefix("job-")), result)

    with Callback(posttask=finished):
        dask.compute(*tasks, chunksize=1, optimize_graph=False)  # a process takes one job at a time


def _remote(client: Any, jobs: Sequence[Job], done: Done) -> None:
    from distributed import as_completed

    futures = {client.submit(*job, pure=False): number for number, job in enumerate(jobs)}
    for future, result in as_completed(futures, with_results=True):
        done(futures[future], result)


@contextlib.contextmanager
def workers(count: int, scheduler: str | None = None) -> Iterator[Run]:
    """Within the block, a function that computes jobs and passes on each result as soon as it is ready, in any order.

    Parameters
    ----------
    count : int
        Processes of this machine, started once; 1 computes in the calling process.
    scheduler : str or None
        Address of a cluster that computes instead. Its workers need this package and its extra ``lab``.
    """
    check_installed("dask")
    import dask

    if count < 1:
        raise UserError(f"--workers must be at least 1, not {count}; choose a greater one")
    if scheduler is not None:
        check_installed("distributed")
        from distributed import Client

        try:
            client = Client(scheduler, timeout="5s")
        except (OSError, ValueError) as error:
            raise UserError(f"no Dask scheduler answers at {scheduler} ({error}); correct --scheduler or leave it out") from error
        with client:
            yield lambda jobs, done: _remote(client, jobs, done)
    elif count == 1:
        with dask.config.set(scheduler="synchronous"):
            yield _local
    else:
        with _pool(count) as pool, dask.config.set(scheduler="processes", pool=pool):
            yield _local


@contextlib.contextmanager
def _pool(count: int) -> Iterator[ProcessPoolExecutor]:
    """Processes that do not see Ctrl-C, and that end at once if the block raises: a job may take minutes."""
    import multiprocessing

    # A terminal sends SIGINT and SIGHUP to all processes, and each would print a traceback. They inherit what is blocked here.
    before = signal.pthread_sigmask(signal.SIG_BLOCK, (signal.SIGINT, signal.SIGHUP))
    try:
        # Not a fork: the progress bar has a thread.
        pool = ProcessPoolExecutor(count, mp_context=multiprocessing.get_context("spawn"))
        for _ in range(count):
            pool.submit(os.getpid)
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
    try:
        yield pool
    except BaseException:
        pool.shutdown(wait=False, cancel_futures=True)
        for child in multiprocessing.active_children():
            child.terminate()
        raise
    pool.shutdown()
