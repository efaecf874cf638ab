"""golden.cli: a method is a row, and its options follow from its class."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import ClassVar

import pytest

from golden.cli import Parser, add_gateware_options, gateware_config, method_config
from golden.config import FUSED_2, METHODS, Arithmetic, Engine, Fused, MatcherConfig, OnePass, Setting, changed
from golden.errors import UserError
from golden.matcher.parameters import NAMED, default_parameters, read_parameters, write_parameters


@dataclass(frozen=True)
class Plain:
    """A method without the disparity rule, hence without its weights; one of its two switches has the name of another method's."""
    median: bool = True
    smear: bool = True
    penalty: int = 4

    name: ClassVar[str] = "plain"
    ABOUT: ClassVar[str] = "differences, smeared"
    SWITCHES: ClassVar[Mapping[str, str]] = {"median": "median of the disparities", "smear": "smeared disparities"}
    LIMITS: ClassVar[Mapping[str, range]] = {"penalty": range(10)}
    arithmetic = Arithmetic.LINEAR
    engines = (Engine.STREAMING,)
    disparity_scale = 1
    data_max = 300

    def __post_init__(self):
        if self.penalty not in self.LIMITS["penalty"]:
            raise ValueError(f"penalty must be less than 10, not {self.penalty}")

    def result_fields(self, labels, minimum):
        return {"disparity": (labels - 1).bit_length()}

    def settings(self, minimum):
        return {"minimum": Setting(255, minimum, "least disparity", unit="pixels"), "smear": Setting(1, self.smear, "smeared disparities")}

    def with_settings(self, values):
        return replace(self, smear=bool(values.get("smear", self.smear)))

    def about(self):
        return asdict(self)


@pytest.fixture
def plain(monkeypatch):
    """Plain as the third method, whichever others there are."""
    for rows in (METHODS, NAMED):
        for name in rows.keys() - {"thesis", "fused"}:
            monkeypatch.delitem(rows, name)
    monkeypatch.setitem(METHODS, "plain", Plain)
    monkeypatch.setitem(NAMED, "plain", {"plain-1": Plain(), "plain-2": Plain(penalty=9)})


def parsed(*words):
    parser = Parser(prog="test")
    add_gateware_options(parser)
    return parser.parse_args(words)


def test_default_method():
    for config in (method_config(parsed(), 16), method_config(parsed("--method", "thesis"), 16)):
        assert config.method == OnePass()
    assert gateware_config(parsed("--method", "fused"), 16).method == Fused() == default_parameters("fused")


@pytest.mark.parametrize("words, method", [
    ("", Plain()),
    ("--no-refine", Plain(median=False, smear=False)),
    ("--no-refine --smear", Plain(median=False)),
    ("--no-median", Plain(median=False)),
    ("--parameters plain-2 --no-smear", Plain(smear=False, penalty=9)),
    ("--minimum 7 --arithmetic linear --engine streaming", Plain()),
])
def test_further_method(plain, words, method):
    config = gateware_config(parsed("--method", "plain", *words.split()), 16)
    assert (config.method, config.engine, config.minimum) == (method, Engine.STREAMING, 7 if "minimum" in words else 0)


@pytest.mark.parametrize("words, told", [
    ("--method plain --check", "--check belongs to the method fused; choose --method fused or leave it out"),
    ("--method plain --no-fill", "--no-fill belongs to the method fused;"),
    ("--method plain --sub-pixel", "--sub-pixel belongs to the method fused;"),
    ("--method plain --u1 3", "--u1 3 belongs to the method thesis or fused; choose --method thesis or fused or leave it out"),
    ("--method plain --u3 0", "--u3 0 belongs to the method thesis or fused;"),
    ("--method plain --fraction-bits 0", "--fraction-bits 0 belongs to the method thesis;"),
    ("--method plain --arithmetic thesis", "--arithmetic thesis cannot compute the method plain; choose --arithmetic linear or"),
    ("--method plain --engine sequential", "--engine sequential has no method plain; choose --engine streaming or --method thesis"),
    ("--method plain --parameters fused-2", "fused-2 has parameters of the method fused; choose --method fused, or one of plain-1"),
    ("--method fused --parameters plain-1", "plain-1 has parameters of the method plain; choose --method plain, or one of fused-1, "),
    ("--method fused --smear", "--smear belongs to the method plain;"),
    ("--no-median", "--no-median belongs to the method fused or plain; choose --method fused or plain or leave it out"),
    ("--no-refine", "--no-refine belongs to the method fused or plain;"),
    ("--parameters x.toml", "--parameters x.toml belongs to the method fused or plain;"),
    ("--minimum 3", "--minimum 3 belongs to the method fused or plain;"),
    ("--method census", "argument --method: invalid choice: 'census' (choose from"),
    ("--cost plain", "--cost is now --method; write --method plain"),
    ("--cost", "--cost is now --method; write --method thesis|fused"),
])
def test_what_belongs_to_another_method_is_refused(plain, words, told):
    with pytest.raises(UserError) as refused:
        gateware_config(parsed(*words.split()), 16)
    assert str(refused.value).startswith(told)


def test_help_follows_the_methods(plain, capsys):
    with pytest.raises(SystemExit):
        parsed("--help")
    told = " ".join(capsys.readouterr().out.split())
    assert "[--method " + "|".join(METHODS) + "]" in told and "plain: differences, smeared" in told
    assert "--smear" in told and "plain-2" in told and "plain linear" in told
    assert "left neighbour, 0 to 63 (default: thesis 15 grey levels a pixel, fused 17 " in told
    assert "--cost" not in told


def test_files_have_the_table_of_their_method(plain, tmp_path):
    write_parameters(tmp_path / "plain.toml", Plain(penalty=3), "a note")
    write_parameters(tmp_path / "fused.toml", FUSED_2, "a note")
    assert (tmp_path / "plain.toml").read_text() == "# a note\n[plain]\npenalty = 3\n"
    assert read_parameters(tmp_path / "plain.toml", "plain") == Plain(penalty=3)
    assert read_parameters(tmp_path / "fused.toml", "fused") == changed(FUSED_2)
    with pytest.raises(UserError, match=r"fused.toml is not one table \[plain\]; name a file with parameters of the method plain"):
        read_parameters(tmp_path / "fused.toml", "plain")


def test_method_without_the_rule(plain):
    """It has settings, and no energies."""
    config = MatcherConfig(16, method=Plain())
    assert list(config.settings) == ["in_use", "minimum", "smear"]
    assert list(MatcherConfig(method=FUSED_2).settings) == ["u1", "u2", "u3", "in_use", "minimum", "check", "fill", "median"]
    assert config.data_bits == 9 and config.matching_cost == MatcherConfig(method=FUSED_2).matching_cost
    for name in ("energy_bits", "smooth_max"):
        with pytest.raises(ValueError, match="the method must label by the disparity rule, and plain does not"):
            getattr(config, name)
