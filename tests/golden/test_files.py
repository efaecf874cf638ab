"""golden.files and golden.errors: whole files or none; one sentence, status 2."""

import os

import pytest

from golden.errors import UserError, run_cli
from golden.files import atomic, check_output, write_json


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
    ("file.png/a.png", "does not exist"),
    ("pipe.png", "must not be written over"),
])
def test_check_output_refuses(tmp_path, name, message):
    (tmp_path / "folder.png").mkdir()
    (tmp_path / "file.png").touch()
    os.mkfifo(tmp_path / "pipe.png")
    before = sorted(tmp_path.iterdir())
    with pytest.raises(UserError, match=message):
        check_output(tmp_path / name, (".npy", ".png"), option="--json")
    assert sorted(tmp_path.iterdir()) == before


@pytest.mark.skipif(not os.path.isdir("/proc/self"), reason="needs a folder that takes no files from anybody")
def test_check_output_refuses_a_folder_that_takes_no_files():
    with pytest.raises(UserError, match="the folder /proc/self cannot be written"):
        check_output("/proc/self/a.png", (".png",))


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
