"""How commands end: signals at any moment, an encoding without umlauts, a full disk, a pipe that nobody reads."""

import io
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from golden import errors
from golden.errors import UserError, guard_start, run_cli


ROOT = Path(__file__).resolve().parents[2]
FULL = Path("/dev/full")

# A command whose body is the first argument.
COMMAND = """
import sys, time, warnings
from golden.errors import UserError, run_cli
def body(argv):
    exec(argv[0], {**globals()})
sys.exit(run_cli(body, sys.argv[1:], "prog"))
"""

# A half-built design, as Amaranth sees it: it warns as it is dropped.
UNUSED = """
class Design:
    def __del__(self):
        warnings.warn("never used")
designs = [Design() for _ in range(9)]
"""

ENDINGS = [(signal.SIGINT, "interrupted", 130), (signal.SIGTERM, "ended by SIGTERM", 143), (signal.SIGHUP, "ended by SIGHUP", 129)]


def allow_signals():
    """In a child: a shell lets what it starts in the background ignore SIGINT."""
    for number, _, _ in ENDINGS:
        signal.signal(number, signal.SIG_DFL)


def command(body, **options):
    options = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "preexec_fn": allow_signals, **options}
    return subprocess.Popen([sys.executable, "-c", COMMAND, body], cwd=ROOT, **options)


def ended(process):
    out, err = process.communicate(timeout=60)
    return process.returncode, out, err.decode()


@pytest.mark.parametrize("number, told, status", ENDINGS)
def test_signal_before_and_after_the_body(monkeypatch, capsys, number, told, status):
    """While handlers are set the body has not begun: it ends there. While the sentence is said it has ended: the signal is passed on."""
    seen = []
    before = signal.signal(number, lambda number, frame: seen.append(number))
    set_handler, said = signal.signal, errors._say

    def hit(*arguments):
        result = set_handler(*arguments)
        signal.raise_signal(number)
        return result

    def hit_again(*arguments):
        signal.raise_signal(number)
        said(*arguments)

    def refuse(argv):
        raise UserError("that is wrong; do it right")

    try:
        with monkeypatch.context() as context:
            context.setattr(errors.signal, "signal", hit)
            assert run_cli(lambda argv: pytest.fail("began"), [], "prog") == status
        assert capsys.readouterr().err == f"prog: {told}\n"
        seen.clear()        # when the first handlers were set, those before were there still
        with monkeypatch.context() as context:
            context.setattr(errors, "_say", hit_again)
            assert run_cli(refuse, [], "prog") == 2
        assert capsys.readouterr().err == "prog: that is wrong; do it right\n" and seen == [number]
        with monkeypatch.context() as context:      # within another command, that one is ended
            context.setattr(errors, "_say", hit_again)
            assert run_cli(lambda argv: run_cli(refuse, argv, "inner"), [], "prog") == status
        assert capsys.readouterr().err == f"inner: that is wrong; do it right\nprog: {told}\n"
    finally:
        set_handler(number, before)


@pytest.mark.parametrize("number, told, status", ENDINGS)
def test_signal(tmp_path, number, told, status):
    """One line; blocks are left in order; what is half done does not warn."""
    process = command(f"{UNUSED}\ntry:\n print('go', flush=True); time.sleep(60)\nfinally:\n open({str(tmp_path / 'left')!r}, 'w')")
    assert process.stdout.readline() == b"go\n"
    process.send_signal(number)
    assert ended(process) == (status, b"", f"prog: {told}\n")
    assert (tmp_path / "left").exists()


@pytest.mark.parametrize("number, told, status", ENDINGS)
def test_signal_is_no_error(number, told, status):
    """Nothing that catches errors takes it for one."""
    process = command("print('go', flush=True)\ntry:\n time.sleep(60)\nexcept Exception:\n pass")
    process.stdout.readline()
    process.send_signal(number)
    assert ended(process) == (status, b"", f"prog: {told}\n")


def test_second_signal_does_not_disturb_the_end():
    process = command("try:\n print('go', flush=True); time.sleep(60)\nfinally:\n print('going', flush=True); time.sleep(0.5)")
    process.stdout.readline()
    process.send_signal(signal.SIGTERM)
    assert process.stdout.readline() == b"going\n"
    process.send_signal(signal.SIGHUP)
    process.send_signal(signal.SIGINT)
    assert ended(process) == (143, b"", "prog: ended by SIGTERM\n")


def test_end_that_hangs_can_be_interrupted():
    process = command("try:\n print('go', flush=True); time.sleep(60)\nfinally:\n print('going', flush=True); time.sleep(60)")
    process.stdout.readline()
    process.send_signal(signal.SIGTERM)
    process.stdout.readline()
    time.sleep(1.2)
    process.send_signal(signal.SIGINT)
    assert ended(process) == (130, b"", "prog: interrupted\n")


def test_signal_while_something_is_deleted():
    """Python drops exceptions there."""
    process = command("class Slow:\n def __del__(self):\n  print('go', flush=True); time.sleep(1)\nSlow()\ntime.sleep(60)")
    process.stdout.readline()
    process.send_signal(signal.SIGTERM)
    assert ended(process) == (143, b"", "prog: ended by SIGTERM\n")


@pytest.mark.parametrize("number, told, status", ENDINGS)
def test_signal_that_is_swallowed(number, told, status):
    """Whatever was imported or called just then had a handler for everything: once more, later."""
    process = command("""
try:
    print("ready", flush=True)
    time.sleep(60)
except BaseException:
    pass
for _ in range(600):
    time.sleep(0.1)
""")
    assert process.stdout.readline() == b"ready\n"
    process.send_signal(number)
    assert ended(process) == (status, b"", f"prog: {told}\n")


def test_signal_that_is_obeyed_at_length():
    """What cleans up for longer than a swallowed signal is waited for is not disturbed, also where it is called from."""
    process = command("""
def clean_up():
    for _ in range(45):
        time.sleep(0.1)
    print("cleaned up", flush=True)
try:
    print("ready", flush=True)
    time.sleep(60)
finally:
    clean_up()
""")
    assert process.stdout.readline() == b"ready\n"
    process.terminate()
    assert ended(process) == (143, b"cleaned up\n", "prog: ended by SIGTERM\n")


def test_ignored_signal_stays_ignored():
    """As `nohup` asks."""
    process = command("print('go', flush=True); time.sleep(0.5)", preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN))
    process.stdout.readline()
    process.send_signal(signal.SIGHUP)
    assert ended(process) == (0, b"", "")


def test_handlers_are_put_back():
    before = [signal.getsignal(number) for number, _, _ in ENDINGS], sys.unraisablehook
    assert run_cli(lambda argv: None, [], "prog") == 0
    assert ([signal.getsignal(number) for number, _, _ in ENDINGS], sys.unraisablehook) == before


@pytest.mark.parametrize("package", ["golden", "hdl", "sim"])
@pytest.mark.parametrize("number, told, status", ENDINGS)
def test_signal_during_imports(tmp_path, package, number, told, status):
    """A module that is imported by a command before its `run_cli`."""
    folder = tmp_path / "slow" / package
    folder.mkdir(parents=True)
    (folder / "__init__.py").write_text((ROOT / package / "__init__.py").read_text().replace(".errors", "golden.errors").replace(
        "golden" * 2, "golden"))
    (folder / "slow.py").write_text("import time\nprint('go', flush=True)\ntry:\n time.sleep(60)\nexcept BaseException:\n print('caught')")
    if package == "golden":
        for file in (ROOT / "golden").glob("errors.py"):
            (folder / file.name).write_text(file.read_text())
    process = subprocess.Popen([sys.executable, "-m", f"{package}.slow"], cwd=tmp_path / "slow", stdout=subprocess.PIPE,
                               stderr=subprocess.PIPE, preexec_fn=allow_signals, env=os.environ | {"PYTHONPATH": str(ROOT)})
    assert process.stdout.readline() == b"go\n"
    process.send_signal(number)
    assert ended(process) == (status, b"", f"{package}.slow: {told}\n")


@pytest.mark.parametrize("package", ["golden", "hdl", "sim"])
def test_library_leaves_signals_alone(package):
    code = f"import signal; before = signal.getsignal(signal.SIGINT); import {package}; assert signal.getsignal(signal.SIGINT) is before"
    subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=True, preexec_fn=allow_signals)


@pytest.mark.parametrize("encoding, expected", [("ascii", b"B\\xf6gen \\u2192\n"), ("latin-1", b"B\xf6gen \\u2192\n"),
                                                ("utf-8", "Bögen →\n".encode())])
def test_encoding(encoding, expected):
    process = command("print('B\\xf6gen \\u2192')", env=os.environ | {"PYTHONIOENCODING": encoding})
    assert ended(process) == (0, expected, "")


def test_encoding_is_put_back(monkeypatch):
    stream = io.TextIOWrapper(io.BytesIO(), encoding="ascii")
    monkeypatch.setattr(sys, "stdout", stream)
    assert run_cli(lambda argv: print("ö"), [], "prog") == 0
    assert stream.errors == "strict" and stream.buffer.getvalue() == b"\\xf6\n"


@pytest.mark.skipif(not FULL.exists(), reason="needs a device that is always full")
@pytest.mark.parametrize("unbuffered", ["", "1"])
@pytest.mark.parametrize("body", ["print('a')", "print('a', flush=True)", "print('a' * 100_000)", "raise SystemExit(print('help'))"])
def test_full_disk_behind_stdout(body, unbuffered):
    with FULL.open("w") as full:
        process = command(body, stdout=full, env=os.environ | {"PYTHONUNBUFFERED": unbuffered})
        assert ended(process) == (2, None, "prog: cannot write to stdout: No space left on device; redirect it elsewhere\n")


@pytest.mark.skipif(not FULL.exists(), reason="needs a device that is always full")
def test_full_disk_behind_stderr():
    with FULL.open("w") as full:
        process = command("print('a', file=sys.stderr, flush=True)", stderr=full)
        process.communicate(timeout=60)
        assert process.returncode == 2


@pytest.mark.parametrize("unbuffered", ["", "1"])
@pytest.mark.parametrize("body", ["print('a')", "print('a' * 100_000)", "[print(i, flush=True) for i in range(9)]",
                                  "raise SystemExit(print('help'))"])
def test_pipe_that_nobody_reads(body, unbuffered):
    read, write = os.pipe()
    os.close(read)
    with os.fdopen(write, "w") as pipe:
        assert ended(command(body, stdout=pipe, env=os.environ | {"PYTHONUNBUFFERED": unbuffered})) == (141, None, "")


def test_closed_stdout_and_stderr():
    process = command("print('a')", stdout=None, stderr=None, preexec_fn=lambda: [os.close(number) for number in (1, 2)])
    assert process.wait(60) == 0


@pytest.mark.parametrize("error, told", [
    (OSError(28, "No space left on device", "/x/work"), "No space left on device for /x/work; make room, or name another folder with"),
    (OSError(122, "Disk quota exceeded"), "Disk quota exceeded; make room"),
    (FileNotFoundError(2, "No usable temporary directory found in ['/tmp']"), "No usable temporary directory found in ['/tmp']; name"),
])
def test_no_room_for_temporary_files(capsys, error, told):
    def body(argv):
        raise error
    assert run_cli(body, [], "prog") == 2
    err = capsys.readouterr().err
    assert err.startswith(f"prog: {told}") and err.count("\n") == 1


def test_other_broken_pipes_are_not_hidden():
    """Such as that to a program which the command has started."""
    def body(argv):
        raise BrokenPipeError(32, "Broken pipe")
    with pytest.raises(BrokenPipeError):
        run_cli(body, [], "prog")


def test_ignored_signal_stays_ignored_during_imports(monkeypatch):
    monkeypatch.setattr(sys, "argv", ["-m"])
    before = {number: signal.signal(number, signal.SIG_IGN) for number, _, _ in ENDINGS}
    try:
        guard_start()
        assert {signal.getsignal(number) for number in before} == {signal.SIG_IGN}
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
