import pytest

from hdl.yosys import Tool, run_yosys


DESIGN = "module \\top\n  wire input 1 \\a\n  wire output 2 \\y\n  connect \\y \\a\nend\n"


@pytest.mark.parametrize("tool", Tool)
def test_runs_in_the_folder(tool, tmp_path):
    (tmp_path / "design.il").write_text(DESIGN)
    run_yosys(tool, "# a step\nread_rtlil design.il\n\nwrite_json out.json\n", tmp_path)
    assert '"top"' in (tmp_path / "out.json").read_text()


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
