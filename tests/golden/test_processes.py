"""golden.processes: a program that ends when what started it does, and so does all that the program has started."""

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from golden.processes import run_program, started


# Starts another that runs on, and writes its number; then waits too, deaf to SIGTERM if told so.
PARENT = """
import signal, subprocess, sys, time
if sys.argv[2] == "deaf":
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
child = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(60)"])
open(sys.argv[1] + ".new", "w").write(str(child.pid))
import os; os.rename(sys.argv[1] + ".new", sys.argv[1])
time.sleep(60)
"""


def alive(number):
    """Whether a process runs; one that only waits to be collected does not."""
    try:
        return Path(f"/proc/{number}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


def wait_for(condition, seconds=20):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.02)


def test_status_and_output(tmp_path):
    assert run_program([sys.executable, "-c", "import sys; sys.exit(3)"]) == 3
    with started([sys.executable, "-c", "print(input('?'))"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout.read() == "?"     # and its input is empty
    assert process.returncode == 1 and process.stdout.closed and process.stderr.closed


@pytest.mark.skipif(not os.path.isdir("/proc/self"), reason="asks /proc which processes run")
@pytest.mark.parametrize("error", [KeyboardInterrupt, SystemExit, ValueError])
@pytest.mark.parametrize("habit", ["obedient", "deaf"])
def test_nothing_is_left(tmp_path, monkeypatch, error, habit):
    monkeypatch.setattr("golden.processes._GRACE", 1.0)
    note = tmp_path / "note"
    with pytest.raises(error), started([sys.executable, "-c", PARENT, str(note), habit]) as process:
        wait_for(note.exists)
        raise error
    assert process.returncode is not None
    wait_for(lambda: not alive(int(note.read_text())))


# Ends at once, and what it has started removes a file before it ends, which takes it a while.
DRIVER = """
import os, signal, subprocess, sys, time
child = subprocess.Popen([sys.executable, "-c", '''
import os, signal, sys, time
def end(number, frame):
    time.sleep(0.5)
    os.unlink(sys.argv[1])
    sys.exit(1)
signal.signal(signal.SIGTERM, end)
open(sys.argv[1], "x").close()
time.sleep(60)
''', sys.argv[1]])
time.sleep(60)
"""


def test_what_a_program_has_started_may_clean_up(tmp_path):
    """As a compiler does that ``make`` has started."""
    temporary = tmp_path / "cc.s"
    with pytest.raises(KeyboardInterrupt), started([sys.executable, "-c", DRIVER, str(temporary)]):
        wait_for(temporary.exists)
        raise KeyboardInterrupt
    assert not temporary.exists()
