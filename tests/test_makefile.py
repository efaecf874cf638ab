"""The Makefile in folders whose names have spaces and quotes. Every program that it starts is a stand-in: nothing is installed."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest


ROOT = Path(__file__).parent.parent
NAMES = ["plain", "a space", "it's", 'a "b"', "$HOME `id` \\", "ü", "#;&(c) *"]

# Python: notes its arguments; makes a virtual environment, in which it is Python and pip.
PYTHON = """#!/bin/sh
printf '%s|' "$@" >>"$NOTES"; printf '%s\\n' "${PATH%%:*}" >>"$NOTES"
case "$1 $2" in
    *version_info?:2*) echo 3.11 ;;
    "-m venv") mkdir -p "$3/bin" && cp "$0" "$3/bin/python" && cp "$0" "$3/bin/pip" ;;
    "-m pip") exit "${PIP_STATUS:-0}" ;;
esac
"""

pytestmark = pytest.mark.skipif(shutil.which("make") is None, reason="make is not installed")


@pytest.fixture(params=NAMES)
def project(tmp_path, request):
    """A folder of that name with the Makefile, and with stand-ins in a folder of that name, too."""
    folder = tmp_path / "projects" / request.param
    programs = tmp_path / "programs" / request.param
    folder.mkdir(parents=True)
    programs.mkdir(parents=True)
    for name in ("Makefile", "pyproject.toml"):
        shutil.copy(ROOT / name, folder)
    for name in ("g++", "iverilog", "perl", "apt-get", "sudo", "python-stand-in"):
        (programs / name).write_text(PYTHON if name == "python-stand-in" else "#!/bin/sh\nexit 0\n")
        (programs / name).chmod(0o755)
    return folder


def make(folder, *arguments, status=0, **environment):
    """Run make; what the stand-ins noted, and what was printed."""
    programs = folder.parent.parent / "programs" / folder.name
    notes = folder.parent.parent / "notes"
    notes.unlink(missing_ok=True)
    variables = {name: value for name, value in os.environ.items() if name not in ("MAKEFLAGS", "MAKELEVEL", "VENV", "CDPATH")}
    variables |= {"PATH": f"{programs}:/usr/bin:/bin", "PYTHON": str(programs / "python-stand-in"), "NOTES": str(notes), **environment}
    run = subprocess.run(["make", *arguments], cwd=folder, env=variables, capture_output=True, text=True, timeout=60)
    assert run.returncode == status, run.stderr
    lines = notes.read_text().splitlines() if notes.exists() else []
    return [line.split("|") for line in lines if not line.startswith("-c|")], run.stdout, run.stderr


@pytest.mark.parametrize("venv", [None, "my own", "/absolute"])
def test_set_up_once_then_run(project, venv):
    venv_of = {} if venv is None else {"VENV": str(project.parent.parent / "my env") if venv == "/absolute" else venv}
    place = project / venv_of.get("VENV", ".venv")
    ran, out, err = make(project, "setup", **venv_of)
    assert [words[:2] for words in ran] == [["-m", "venv"], ["-m", "pip"]] and err == ""
    assert out.count("Installing") == 1 and (place / ".installed").exists()
    for target, expected in [("setup", []), ("demo", ["sim.demo"]), ("test", ["pytest"]), ("quick", ["pytest"]), ("slow", ["pytest"]),
                             ("site", ["sphinx"]), ("style", ["ruff"]), ("types", ["mypy"])]:
        ran, out, err = make(project, target, CDPATH=str(project), **venv_of)
        assert [words[1] for words in ran] == expected and err == "" and "Installing" not in out
        if target in ("demo", "test", "quick", "slow"):
            assert ran[0][-1] == str(place / "bin")      # first on the path
    os.utime(project / "pyproject.toml", (2e9, 2e9))
    assert [words[:2] for words in make(project, "setup", **venv_of)[0]] == [["-m", "pip"]]
    assert {path.name for path in project.iterdir()} <= {"Makefile", "pyproject.toml", "build", ".venv", "my own"}


def test_site_without_a_package(project):
    """One sentence, and no traceback of Sphinx."""
    make(project, "setup")
    python = project / ".venv" / "bin" / "python"
    python.write_text("#!/bin/sh\necho \"Traceback\nModuleNotFoundError: No module named 'furo'\" >&2\nexit 1\n")
    _, out, err = make(project, "site", status=2)
    assert out == "" and err.splitlines()[0] == (
        "make site: No module named 'furo'; remove .venv/.installed, and make site installs it")
    assert not (project / "build").exists()


def test_pip_is_blamed_for_what_it_did(project):
    _, _, err = make(project, "setup", status=2, PIP_STATUS="1")
    assert "cannot be installed into .venv; pip's reason is above" in err and not (project / ".venv" / ".installed").exists()


def test_python_that_cannot_be_run(project):
    """Neither is there such a program, nor can it be installed."""
    ran, _, err = make(project, "setup", status=2, PYTHON=str(project / "none"))
    assert "Still missing although apt-get succeeded" in err and "pip" not in err and ran == []


def test_clean(project):
    for name in ("build/a", ".mypy_cache/a", "golden/__pycache__/a", "golden/a.py", "hdl/a.py", "boards/a", "sim/a", "tests/a", ".venv/a"):
        (project / name).parent.mkdir(parents=True, exist_ok=True)
        (project / name).touch()
    make(project, "clean")
    left = {str(path.relative_to(project)) for path in project.rglob("*") if path.is_file()}
    assert left == {"Makefile", "pyproject.toml", "golden/a.py", "hdl/a.py", "boards/a", "sim/a", "tests/a", ".venv/a"}
