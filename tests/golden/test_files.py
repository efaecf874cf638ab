"""golden.files and golden.errors: whole files or none; one sentence, status 2."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from golden.errors import UserError, run_cli
from golden.files import atomic, check_folder, check_output, output_folder, remove_stale, write_json


def test_atomic_replaces(tmp_path):
    target = tmp_path / "a.bin"
    target.write_bytes(b"old")
    os.link(target, tmp_path / "same.bin")
    with atomic(target) as file:
        file.write(b"new")
        file.flush()
        assert target.read_bytes() == b"old"
    assert target.read_bytes() == b"new"
    assert (tmp_path / "same.bin").read_bytes() == b"old"  # another file took the place; this one was not written into
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.bin", "same.bin"]


def test_atomic_leaves_the_old_file_when_it_fails(tmp_path):
    target = tmp_path / "a.bin"
    target.write_bytes(b"old")
    with pytest.raises(RuntimeError), atomic(target) as file:
        file.write(b"half")
        raise RuntimeError
    assert target.read_bytes() == b"old"
    assert [path.name for path in tmp_path.iterdir()] == ["a.bin"]


def test_atomic_permissions_and_links(tmp_path):
    (tmp_path / "folder").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "folder" / "a.bin")
    umask = os.umask(0o022)
    try:
        with atomic(tmp_path / "link") as file:
            file.write(b"1")
    finally:
        os.umask(umask)
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "folder" / "a.bin").stat().st_mode & 0o777 == 0o644


def test_atomic_without_folder(tmp_path):
    with pytest.raises(UserError, match=r"cannot write .*a\.bin"), atomic(tmp_path / "none" / "a.bin"):
        pass


def test_check_output_accepts(tmp_path):
    for name in ("new.png", "NEW.PNG"):
        assert check_output(tmp_path / name, (".png",)) == tmp_path / name
    (tmp_path / "old.png").write_bytes(b"old")
    check_output(tmp_path / "old.png", (".png",))
    assert (tmp_path / "old.png").read_bytes() == b"old"
    assert [path.name for path in tmp_path.iterdir()] == ["old.png"]


@pytest.mark.parametrize("name, message", [
    ("a.jpg", r"suffix \.jpg, which is not one of \.npy, \.png; choose one of these for --json"),
    ("a", r"suffix \(none\)"),
    ("folder.png", "is a folder; name a file in it with --json"),
    ("none/a.png", r"the folder .*none of a\.png does not exist"),
    ("file.png/a.png", r"file\.png is a file, not a folder; choose another --json"),
    ("file.png/b/c/a.png", r"file\.png is a file, not a folder; choose another --json"),
    ("link/a.png", "link is a link that leads nowhere; choose another --json"),
    ("pipe.png", "must not be written over"),
])
def test_check_output_refuses(tmp_path, name, message):
    (tmp_path / "folder.png").mkdir()
    (tmp_path / "file.png").touch()
    os.mkfifo(tmp_path / "pipe.png")
    (tmp_path / "link").symlink_to(tmp_path / "nowhere")
    before = sorted(tmp_path.iterdir())
    with pytest.raises(UserError, match=message):
        check_output(tmp_path / name, (".npy", ".png"), option="--json")
    assert sorted(tmp_path.iterdir()) == before


@pytest.mark.skipif(not os.path.isdir("/proc/self"), reason="needs a folder that takes no files from anybody")
def test_check_output_refuses_a_folder_that_takes_no_files():
    with pytest.raises(UserError, match="the folder /proc/self cannot be written"):
        check_output("/proc/self/a.png", (".png",))


def test_names_of_temporary_files(tmp_path):
    """A name as long as can be, and one that a killed run has left."""
    name = "a" * 251 + ".png"
    check_output(tmp_path / name, (".png",))
    with atomic(tmp_path / name) as first, atomic(tmp_path / name) as second:
        first.write(b"first")
        second.write(b"second")
    assert (tmp_path / name).read_bytes() == b"first" and len(list(tmp_path.iterdir())) == 1


@pytest.mark.parametrize("check", [check_folder, lambda path, option: output_folder(path, option).__enter__()])
@pytest.mark.parametrize("name, told", [("file", "file is a file, not a folder"), ("file/a/b", "file is a file, not a folder"),
                                        ("link/a", "link is a link that leads nowhere"), ("/proc/none", "/proc/none cannot be written")])
def test_folder_is_refused(tmp_path, monkeypatch, check, name, told):
    monkeypatch.chdir(tmp_path)
    Path("file").touch()
    Path("link").symlink_to("nowhere")
    with pytest.raises(UserError, match=f"{told}.*; choose another --json"):
        check(name, option="--json")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file", "link"]


@pytest.mark.parametrize("name", ["new", "new/a/b", ".", "here"])
def test_folder_is_accepted(tmp_path, monkeypatch, name):
    """Checked without being made; what is in it stays."""
    monkeypatch.chdir(tmp_path)
    Path("here").mkdir()
    Path("here", ".probe").write_text("mine")
    check_folder(name)
    assert not Path("new").exists()
    with output_folder(name) as folder:
        (folder / "a").touch()
    assert Path(name, "a").exists() and Path("here", ".probe").read_text() == "mine"


# Holds the folder until its input ends, or prints why it cannot.
HOLDER = """
import sys
from golden.errors import UserError
from golden.files import output_folder
try:
    with output_folder(sys.argv[1], wait=len(sys.argv) > 2):
        print("holds", flush=True)
        sys.stdin.read()
except UserError as error:
    print(error)
"""


def holder(folder, *wait):
    return subprocess.Popen([sys.executable, "-c", HOLDER, folder, *wait], cwd=Path(__file__).parents[2], stdin=subprocess.PIPE,
                            stdout=subprocess.PIPE, text=True)


@pytest.mark.parametrize("end", ["in order", "killed"])
def test_folder_of_one_run(tmp_path, end):
    """The second is refused, or waits; by whatever name."""
    (tmp_path / "link").symlink_to(tmp_path / "out")
    first = holder(tmp_path / "out")
    assert first.stdout.readline() == "holds\n"
    refused = holder(tmp_path / "link").communicate(timeout=60)[0]
    assert refused == f"the folder {tmp_path / 'link'} is in use by another run; wait for its end, or choose another --output\n"
    other = holder(tmp_path / "other")
    assert other.communicate(timeout=60)[0] == "holds\n"
    waiting = holder(tmp_path / "out", "wait")
    with pytest.raises(subprocess.TimeoutExpired):
        waiting.wait(0.5)
    if end == "killed":
        first.kill()
    first.communicate(timeout=60)
    assert waiting.communicate(timeout=60)[0] == "holds\n"
    assert list((tmp_path / "out").iterdir()) == []


KEYS = ("mismatches", "seed")
LISTED = ["old.png", "new.png", "gone.png", "../beside.png", "folder", "report.json", "sub/a.png"]


@pytest.mark.parametrize("document, removed", [
    ({"mismatches": 0, "seed": 1, "files": LISTED}, {"old.png"}),
    ({"mismatches": 0, "files": LISTED}, set()),         # somebody else's
    ({"mismatches": 0, "seed": 1}, set()), ([], set()), (None, set()), ({"mismatches": 0, "seed": 1, "files": None}, set()),
    ({"mismatches": 0, "seed": 1, "files": [7]}, set()),
])
def test_stale_files(tmp_path, document, removed):
    """Those alone that an earlier run says it wrote, and this one did not."""
    folder = tmp_path / "out"
    (folder / "folder").mkdir(parents=True)
    (folder / "sub").mkdir()
    for name in ("old.png", "new.png", "mine.png", "../beside.png", "sub/a.png"):
        (folder / name).touch()
    (folder / "report.json").write_text(json.dumps(document) if document is not None else "text")
    before = {*tmp_path.rglob("*")}
    remove_stale(folder, "report.json", KEYS, ["new.png"])
    assert before - {*tmp_path.rglob("*")} == {folder / name for name in removed}


def test_no_stale_files_without_a_manifest(tmp_path):
    (tmp_path / "a").touch()
    remove_stale(tmp_path, "report.json", KEYS, [])
    assert [path.name for path in tmp_path.iterdir()] == ["a"]


@pytest.mark.parametrize("text", ["[" * 100_000, json.dumps({"files": ["\0", "\ud800"], **dict.fromkeys(KEYS)})], ids=["deep", "no names"])
def test_no_stale_files_of_a_hostile_manifest(tmp_path, text):
    (tmp_path / "report.json").write_text(text)
    remove_stale(tmp_path, "report.json", KEYS, [])
    assert (tmp_path / "report.json").read_text() == text


def fail(error):
    raise error


@pytest.mark.parametrize("function, status, printed", [
    (lambda argv: None, 0, ""),
    (lambda argv: len(argv), 3, ""),
    (lambda argv: fail(UserError("the value 7\nis too large; choose 6")), 2, "prog: the value 7 is too large; choose 6\n"),
    (lambda argv: fail(MemoryError("8 GiB")), 2, "prog: not enough memory: 8 GiB; use a smaller picture or fewer disparities\n"),
    (lambda argv: fail(KeyboardInterrupt()), 130, "prog: interrupted\n"),
])
def test_run_cli(capsys, function, status, printed):
    assert run_cli(function, ["a", "b", "c"], "prog") == status
    assert capsys.readouterr() == ("", printed)


def test_run_cli_shows_what_is_not_the_users_fault():
    with pytest.raises(ZeroDivisionError):
        run_cli(lambda argv: fail(ZeroDivisionError()), [], "prog")


def test_json_is_indented_and_ends_its_line(tmp_path):
    write_json(tmp_path / "a.json", {"a": [1, 2.5]})
    assert (tmp_path / "a.json").read_text() == '{\n  "a": [\n    1,\n    2.5\n  ]\n}\n'


def test_bad_input_is_a_value_error():
    """Callers of the library need not know how a command line prints it."""
    with pytest.raises(ValueError, match="holds no known disparity"):
        raise UserError("a.png holds no known disparity; give another")
