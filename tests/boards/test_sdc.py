import pytest

from boards.altera.sdc import Bounds, Design, matching, read_sdc


DESIGN = Design(
    ports=["pad", "bus[0]", "bus[1]", "clk__io"], pins=["pll|clk[0]"], pll_clocks=["pll|clk[0]"],
    registers=lambda pattern: matching(["core|stage0[0]", "core|stage0[1]", "core|flag"], pattern))
TWO = "create_clock -name a -period 10 [get_ports {pad}]\ncreate_clock -name b -period 4.5 [get_ports {bus[0]}]\n"
BETWEEN = "-from [get_clocks {a}] -to [get_clocks {b}]"
WIDE = f"{TWO}set_max_delay {BETWEEN} 100\nset_min_delay {BETWEEN} -100\n"
REGISTERS = ["core|stage0[0]", "core|stage0[1]"]


def test_clocks_in_their_order():
    said = read_sdc(f"# derive_pll_clocks\n{TWO}\nderive_pll_clocks\n"
                    "create_generated_clock -name sent \\\n   -source [get_pins {pll|clk[0]}] -invert [get_ports {bus[1]}]\n"
                    "set outputs [get_ports {bus[*] pad}]\nset_output_delay -clock sent -max 1.2 $outputs\n"
                    "set_clock_groups -asynchronous -group [get_clocks {pll|* sent}] -group [get_clocks {a}]\n", DESIGN)
    assert said.problems == []
    assert said.clocks == {"a": 10, "b": 4.5, "pll|clk[0]": None, "sent": None}
    assert said.groups == [[frozenset({"pll|clk[0]", "sent"}), frozenset({"a"})]]


@pytest.mark.parametrize("command, told", [
    ("set_clock_groups -asynchronous -group [get_clocks {a}]", "no clock a has been created by then"),
    ("set_output_delay -clock a -max 1 [get_ports {pad}]", "no clock a has been created by then"),
    ("set_false_path -to [get_clocks {pll|*}]", "no clock pll|* has been created by then"),
    ("set_false_path -to [get_ports {bus[2]}]", "no port bus[2] is in the design"),
    ("set_false_path -to [get_ports {bus}]", "no port bus is in the design"),
    ("set_false_path -to [get_registers {core|stage1[*]}]", "no register core|stage1[*] is in the design"),
    ("create_generated_clock -name g -source [get_pins {pll|clk[1]}] [get_ports {pad}]", "no pin pll|clk[1] is in the design"),
    ("create_clock -name a -period 9 [get_ports {bad}]", "no port bad is in the design"),
    ("set_max_skew 1", "the command 'set_max_skew' is not one that is checked"),
    ("set_false_path -through [get_ports {pad}]", "set_false_path has the option -through, which is not one that is checked"),
    ("set_max_delay -to [get_ports {pad}]", "set_max_delay has 0 arguments without an option, not 1"),
    ("set_max_delay -to [get_ports {pad}] soon", "set_max_delay has 'soon' where a number of nanoseconds belongs"),
    ("set_false_path -to pad", "set_false_path has 'pad' where a filter such as [get_ports ...] belongs"),
    ("set_false_path -to $pads", "the variable pads has no value yet"),
    ("create_clock -period 9 [get_ports {pad}]", "create_clock has no -name"),
    ("foreach x {1 2} { puts $x }", "the command 'foreach' is not one that is checked"),
    ("set x {a {b}}", "'{a' is beyond the subset of Tcl that is checked"),
    ('set name "text"', "'\"text\"' is beyond the subset of Tcl that is checked"),
])
def test_wrong_line(command, told):
    """One sentence with the line's number, and the lines that follow are read."""
    last = "create_clock -name last -period 1 [get_ports {pad}]"
    said = read_sdc(f"\n# one\nset pads_ \\\n  [get_ports {{pad}}]\n{command}\n{last}\n", DESIGN)
    assert said.problems == [f"line 5: {told}"]
    assert "last" in said.clocks


def test_brackets_are_literal_and_levels_are_not_crossed_by_a_name():
    assert matching(["a[0]", "a0", "a[10]"], "a[0]") == ["a[0]"]
    assert matching(["a[0]", "a0", "a[10]"], "a[*]") == ["a[0]", "a[10]"]


@pytest.mark.parametrize("more, bounds", [
    ("", Bounds(-100, 100)),
    # Registers have priority over clocks, whichever comes first; of equals the later one applies.
    ("set_max_delay -from [get_clocks {a}] -to [get_registers {core|stage0[*]}] 7", Bounds(-100, 7)),
    ("set_max_delay -to [get_registers {core|stage0[*]}] 7\nset_max_delay -to [get_registers {core|*}] 8", Bounds(-100, 8)),
    ("set_max_delay -from [get_clocks {a}] -to [get_clocks {b}] 50", Bounds(-100, 50)),
    # Not all bits, or another clock.
    ("set_max_delay -to [get_registers {core|stage0[1]}] 7", Bounds(-100, 100)),
    ("set_max_delay -from [get_clocks {b}] -to [get_registers {core|stage0[*]}] 7", Bounds(-100, 100)),
    # Cut.
    ("set_false_path -from [get_clocks {a}]", Bounds(None, None)),
    ("set_false_path -to [get_registers {core|stage0[*]}]", Bounds(None, None)),
    ("set_clock_groups -asynchronous -group [get_clocks {a}] -group [get_clocks {b}]", Bounds(None, None)),
    ("set_clock_groups -asynchronous -group [get_clocks {a b}] -group [get_clocks {pll|*}]", Bounds(-100, 100)),
    ("set_false_path -from [get_clocks {b}]", Bounds(-100, 100)),
])
def test_what_applies_to_a_crossing(more, bounds):
    for text in (f"derive_pll_clocks\n{WIDE}{more}\n", f"{TWO}derive_pll_clocks\n{more}\n{WIDE.removeprefix(TWO)}"):
        said = read_sdc(text, DESIGN)
        assert said.problems == []
        if "50" not in more or text.endswith("50\n"):
            assert said.bounds({"a"}, {"b"}, REGISTERS) == bounds


def test_other_clocks_have_no_bounds():
    assert read_sdc(WIDE, DESIGN).bounds({"b"}, {"a"}) == Bounds(None, None)
