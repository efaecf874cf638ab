from pathlib import Path

import pytest

from hdl.yosys import Tool, run_yosys, tool_environment


DESIGN = "module \\top\n  wire input 1 \\a\n  wire output 2 \\y\n  connect \\y \\a\nend\n"


@pytest.mark.parametrize("tool", Tool)
def test_runs_in_the_folder(tool, tmp_path):
    (tmp_path / "design.il").write_text(DESIGN)
    run_yosys(tool, "# a step\nread_rtlil design.il\n\nwrite_json out.json\n", tmp_path)
    assert '"top"' in (tmp_path / "out.json").read_text()


@pytest.mark.parametrize("name", ["a space", "it's", "$x", 'a "b"', "ü"])
def test_temporary_folder(tmp_path, monkeypatch, name):
    """ABC, which a shell starts, works wherever that is, and where the working folder is."""
    folder = tmp_path / name
    folder.mkdir()
    monkeypatch.setenv("TMPDIR", str(folder))
    (folder / "design.il").write_text("module \\top\n  wire input 1 \\a\n  wire input 2 \\b\n  wire output 3 \\y\n"
                                      "  cell $and $1\n    parameter \\A_SIGNED 0\n    parameter \\A_WIDTH 1\n    parameter \\B_SIGNED 0\n"
                                      "    parameter \\B_WIDTH 1\n    parameter \\Y_WIDTH 1\n    connect \\A \\a\n    connect \\B \\b\n"
                                      "    connect \\Y \\y\n  end\nend\n")
    run_yosys(Tool.PYOSYS, "read_rtlil design.il\ntechmap\nabc -lut 4\nwrite_json out.json\n", folder)
    assert '"$lut"' in (folder / "out.json").read_text()


def test_steps_are_reported(tmp_path):
    steps = []
    run_yosys(Tool.PYOSYS, "# one\n# two parts\nhierarchy\n", tmp_path, steps.append)
    assert steps == ["one", "two parts"]


@pytest.mark.parametrize("tool", Tool)
@pytest.mark.parametrize("script, told", [("read_rtlil none.il\n", "none.il"), ("no_such_command\n", "no_such_command")])
def test_failure(tool, script, told, tmp_path):
    """Also after a success in the same folder."""
    run_yosys(tool, "hierarchy\n", tmp_path)
    with pytest.raises(RuntimeError, match=rf"(?s)^Yosys failed: .*{told}"):
        run_yosys(tool, script, tmp_path)


@pytest.mark.parametrize("how", ["XDG_CACHE_HOME", "HOME", "wasmtime", "YoWASP"])
def test_cache_that_cannot_be_written(tmp_path, monkeypatch, how):
    """The tool is compiled all the same, into a folder that this process removes."""
    home = tmp_path / "home"
    (home / ".cache").mkdir(parents=True)
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setenv("HOME", str(home))
    assert "XDG_CACHE_HOME" not in tool_environment()
    (tmp_path / "file").touch()
    if how in ("HOME", "XDG_CACHE_HOME"):
        monkeypatch.setenv(how, str(tmp_path / "file" / "below"))
    else:
        (home / ".cache" / how).touch()
    folder = tool_environment()["XDG_CACHE_HOME"]
    assert tmp_path not in Path(folder).parents and Path(folder).is_dir()
    assert tool_environment()["XDG_CACHE_HOME"] == folder     # one for all runs of this process
    if how == "HOME":
        test_runs_in_the_folder(Tool.AMARANTH, tmp_path)
        assert (Path(folder) / "wasmtime").is_dir()


def test_relative_cache_is_none(tmp_path, monkeypatch):
    """As for all programs that keep to the rule of XDG."""
    monkeypatch.setenv("XDG_CACHE_HOME", "relative")
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.chdir(tmp_path)
    assert tool_environment()["XDG_CACHE_HOME"] == "relative"
    assert [path.name for path in tmp_path.iterdir()] == [".cache"]


def test_mounts_of_other_tools_are_not_seen(monkeypatch):
    monkeypatch.setenv("YOWASP_MOUNT", "/none=/none")
    assert "YOWASP_MOUNT" not in tool_environment()
