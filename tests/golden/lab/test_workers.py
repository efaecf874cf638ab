"""golden.lab.workers: every job's result is returned under the number of the job, wherever it is computed."""

import math
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from golden.errors import UserError
from golden.lab.workers import check_installed, workers


pytest.importorskip("dask", reason="dask, of the extra lab, is not installed")


ROOT = Path(__file__).resolve().parents[3]
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


# Two jobs that take a minute, in processes of their own; the first line is printed when both run.
SLOW = """
import sys, time
from golden.errors import run_cli
from golden.lab.workers import workers
def job(note):
    open(note, "w").close()
    time.sleep(60)
def body(argv):
    with workers(2) as run:
        run([(job, note) for note in argv], lambda number, result: None)
if __name__ == "__main__":
    sys.exit(run_cli(body, sys.argv[1:], "prog"))
"""


def _heed_signals():
    """A shell in the background ignores SIGINT, and ``nohup`` SIGHUP, and what they start inherits that."""
    for number in (signal.SIGINT, signal.SIGHUP):
        signal.signal(number, signal.SIG_DFL)


# Slow: SIGHUP to one process, as SIGTERM is sent.
@pytest.mark.parametrize("to_all, number, told", [
    (True, signal.SIGINT, "interrupted"), (False, signal.SIGINT, "interrupted"), (True, signal.SIGHUP, "ended by SIGHUP"),
    pytest.param(False, signal.SIGHUP, "ended by SIGHUP", marks=pytest.mark.slow), (False, signal.SIGTERM, "ended by SIGTERM")])
def test_signal(tmp_path, number, told, to_all):
    """To all processes, as a terminal sends it, or to the first alone: one line, at once, and no process is left."""
    (tmp_path / "slow.py").write_text(SLOW)
    notes = [tmp_path / "left", tmp_path / "right"]
    process = subprocess.Popen([sys.executable, "slow.py", *map(str, notes)], cwd=tmp_path, stderr=subprocess.PIPE, text=True,
                               start_new_session=True, env=os.environ | {"PYTHONPATH": str(ROOT)},
                               preexec_fn=_heed_signals)
    end = time.monotonic() + 60
    while not all(note.exists() for note in notes) and time.monotonic() < end:
        time.sleep(0.05)
    if to_all:  # but for SIGTERM, which ends the others themselves
        os.killpg(process.pid, number)
    else:
        process.send_signal(number)
    assert process.communicate(timeout=20)[1] == f"prog: {told}\n" and process.returncode == 128 + number
    end = time.monotonic() + 20
    with pytest.raises(ProcessLookupError):     # the group is empty
        while time.monotonic() < end:
            os.killpg(process.pid, 0)
            time.sleep(0.05)
