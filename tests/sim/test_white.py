"""``--white`` of the simulations: it reaches the pictures, and is refused as elsewhere. No simulator runs here."""

import numpy as np
import pytest
from PIL import Image

from golden.errors import UserError
from sim import run, system


COMMANDS = [(run, ["--disparities", "8"]), (system, [])]


@pytest.fixture
def pair(tmp_path, monkeypatch):
    """The names of a pair of 10 bits in the working folder."""
    monkeypatch.chdir(tmp_path)
    for name in ("left.png", "right.png"):
        Image.fromarray(np.array([[0, 500, 1023]], np.uint16)).save(name)
    return ["left.png", "right.png"]


@pytest.mark.parametrize("command, arguments", COMMANDS)
@pytest.mark.parametrize("option, white", [(["--white", "1023"], 1023), ([], None)])
def test_white_reaches_the_pictures(pair, monkeypatch, command, arguments, option, white):
    seen = []

    def read(*given):
        seen.append(given)
        raise UserError("seen")

    monkeypatch.setattr(command, "read_pair", read)
    assert command.main([*pair, *option, *arguments]) == 2
    assert seen == [(*pair, white)]


@pytest.mark.parametrize("command, arguments", COMMANDS)
@pytest.mark.parametrize("names, white, message", [
    (True, 70000, "--white must be a whole number from 1 to 65535, not 70000"), (True, 1022, "1023 at most"),
    (False, 1023, "--white 1023 is for LEFT and RIGHT, which are missing")])
def test_white_refused(pair, capsys, command, arguments, names, white, message):
    assert command.main([*pair * names, "--white", str(white), *arguments]) == 2
    printed = capsys.readouterr()
    assert message in printed.err and printed.err.count("\n") == 1 and printed.out == ""
