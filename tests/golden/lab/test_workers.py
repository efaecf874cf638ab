"""golden.lab.workers: every job's result is returned under the number of the job, wherever it is computed."""

import math
import os

import pytest

from golden.errors import UserError
from golden.lab.workers import check_installed, workers


pytest.importorskip("dask", reason="dask, of the extra lab, is not installed")


JOBS = [(math.hypot, 3 * k, 4 * k) for k in range(7)]


def results(run, jobs):
    found = {}
    run(jobs, found.__setitem__)
    return found


def test_in_this_process():
    with workers(1) as run:
        assert results(run, JOBS) == {k: 5.0 * k for k in range(7)}
        assert results(run, [(os.getpid,)]) == {0: os.getpid()}
        assert results(run, []) == {}


def test_in_two_processes():
    with workers(2) as run:
        assert results(run, JOBS) == {k: 5.0 * k for k in range(7)}
        assert os.getpid() not in results(run, [(os.getpid,)] * 3).values()


def test_results_are_handed_on_before_the_end():
    """What was computed before a failure is not lost."""
    seen = {}
    with workers(1) as run, pytest.raises(ZeroDivisionError):
        run([(math.sqrt, 4), (divmod, 1, 0), (math.sqrt, 9)], seen.__setitem__)
    assert seen


@pytest.mark.parametrize("count", [0, -1])
def test_count(count):
    with pytest.raises(UserError, match=f"--workers must be at least 1, not {count}"), workers(count):
        pass


def test_a_package_that_is_missing():
    check_installed("dask", "math")
    with pytest.raises(UserError, match="no_such_package is not installed; install the extra lab"):
        check_installed("dask", "no_such_package")


def test_on_a_cluster():
    distributed = pytest.importorskip("distributed", reason="distributed, of the extra lab, is not installed")
    with distributed.LocalCluster(n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None) as cluster:
        with workers(5, cluster.scheduler_address) as run:
            assert results(run, JOBS) == {k: 5.0 * k for k in range(7)}


def test_no_cluster():
    pytest.importorskip("distributed", reason="distributed, of the extra lab, is not installed")
    with pytest.raises(UserError, match="no Dask scheduler answers at nonsense"), workers(1, "nonsense://here"):
        pass
