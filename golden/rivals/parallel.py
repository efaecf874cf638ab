"""Tasks through Dask: in processes of this machine, or on a cluster."""

import contextlib
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from typing import Any

from ..cli import Parser
from ..errors import UserError
from .options import check_installed


__all__ = ["add_worker_options", "compute", "workers"]


TIMEOUT = 5  # seconds until a cluster must have answered

Compute = Callable[[Sequence[Any], Callable[[], object]], list[Any]]


def add_worker_options(parser: Parser, count: int) -> None:
    """Add ``--workers`` and ``--scheduler``."""
    parser.add_argument("--workers", type=int, default=count, metavar="N", help="processes (default: %(default)s)")
    parser.add_argument("--scheduler", metavar="ADDRESS", help="compute on the Dask cluster there, tcp://HOST:PORT, not in processes here")


def _local(tasks: Sequence[Any], advance: Callable[[], object]) -> list[Any]:
    """Compute within what :func:`workers` has set up."""
    import dask  # here, because it takes longer to load than all the rest
    from dask.callbacks import Callback

    with Callback(posttask=lambda *_: advance()):
        return list(dask.compute(*tasks, chunksize=1))  # a process takes one task at a time


def _remote(client: Any, tasks: Sequence[Any], advance: Callable[[], object]) -> list[Any]:
    from distributed import as_completed

    futures = client.compute(list(tasks))
    for _ in as_completed(futures):
        advance()
    return list(client.gather(futures))


@contextlib.contextmanager
def workers(count: int, scheduler: str | None = None) -> Iterator[Compute]:
    """Within the block, a function that computes tasks of Dask and calls back after each; the results keep the order of the tasks.

    Parameters
    ----------
    count : int
        Processes of this machine, which are started once; 1 computes in this one.
    scheduler : str or None
        A cluster's address, in place of them. Its workers must have this package and the extra ``lab``.
    """
    check_installed(["dask"])
    import dask

    if count < 1:
        raise UserError(f"--workers must be at least 1, not {count}; choose a greater one")
    if scheduler is not None:
        check_installed(["distributed"])
        from distributed import Client

        try:
            client = Client(scheduler, timeout=TIMEOUT)
        except (OSError, ValueError) as error:
            raise UserError(f"no Dask scheduler answers at {scheduler} ({error}); correct --scheduler or leave it out") from error
        with client:
            yield lambda tasks, advance: _remote(client, tasks, advance)
    elif count == 1:
        with dask.config.set(scheduler="synchronous"):
            yield _local
    else:
        import multiprocessing

        # Not a fork: the progress bar has a thread.
        with (ProcessPoolExecutor(count, mp_context=multiprocessing.get_context("spawn")) as pool,
              dask.config.set(scheduler="processes", pool=pool)):
            yield _local


def compute(run: Compute, function: Callable[..., Any], arguments: Sequence[tuple[Any, ...]], advance: Callable[[], object]) -> list[Any]:
    """``function(*a)`` for each of ``arguments``, in order, by what :func:`workers` gives."""
    import dask

    return run([dask.delayed(function, pure=False)(*each) for each in arguments], advance)
