"""golden.matcher.parameters: files that are read as they were written, and invalid files."""

import pytest

from golden.config import FUSED_1, changed
from golden.errors import UserError
from golden.matcher.parameters import read_parameters, write_parameters


PARAMETERS = changed(FUSED_1, truncation=100, cost_factor=3, census_weight=20, cost_shift=3, cost_outside=29, census_rows=3,
                     census_columns=9, arm_threshold=9, reach=15, u1=16, u2=29, u3=21, energy_shift=2, tolerance=2, median_size=3)


def test_back_and_forth(tmp_path):
    write_parameters(tmp_path / "a.toml", PARAMETERS, "first line\nsecond line")
    assert read_parameters(tmp_path / "a.toml", "fused") == PARAMETERS
    assert (tmp_path / "a.toml").read_text().startswith("# first line\n# second line\n[fused]\ntruncation = 100\n")


def test_what_is_not_named_is_the_default(tmp_path):
    (tmp_path / "a.toml").write_text("[fused]\nu1 = 3\n")
    assert read_parameters(tmp_path / "a.toml", "fused") == changed(FUSED_1, u1=3)
    (tmp_path / "a.toml").write_text("[fused]\n")
    assert read_parameters(tmp_path / "a.toml", "fused") == FUSED_1


@pytest.mark.parametrize("text, message", [
    (None, "cannot read .*a.toml: No such file"),
    ("u1 =", "a.toml is not a TOML file"),
    ("", r"a.toml is not one table \[fused\]"),
    ("fused = " + "[" * 100_000, "a.toml is not a TOML file: its brackets are nested too deeply"),
    ("fused = 3", r"a.toml is not one table \[fused\]"),
    ("[fused]\n[other]", r"a.toml is not one table \[fused\]"),
    ("[fused]\nu4 = 3", "a.toml names u4, which is no parameter; those are truncation, "),
    ("[fused]\nu1 = 64", "a.toml: u1 must be a whole number from 0 to 63, not 64; correct the file"),
    ("[fused]\nu1 = 1.5", "u1 must be a whole number from 0 to 63, not 1.5"),
    ("[fused]\ntruncation = 1000", "the fused cost reaches 349"),
])
def test_bad_files(tmp_path, text, message):
    if text is not None:
        (tmp_path / "a.toml").write_text(text)
    with pytest.raises(UserError, match=message):
        read_parameters(tmp_path / "a.toml", "fused")
