"""Project files for Quartus II 9.1 to 13.1 around :class:`boards.cyclone3.top.BoardTop`, through Amaranth's templates."""

from fractions import Fraction
from importlib import resources
from typing import ClassVar

from golden.config import MatcherConfig
from golden.video.formats import PAL, DisplayFormat
from hdl.netlist import Cell, Hierarchy

from ..altera.crossings import gray_constraints
from ..altera.platform import OUTSIDE_CLOCKS, file_templates, settings_template
from ..altera.synchronizers import ATTRIBUTE
from ..emission import NAME, emitted_files
from ..registry import Project, System
from .blocks import BLOCKS, MEMORY_CONTROLLER
from .platform import Cyclone3Platform
from .top import BoardTop, pll_ratio


__all__ = ["DDR2_SCRIPT", "StereoPlatform", "quartus_project"]


#: The script that compares the generated memory controller with what this project connects.
DDR2_SCRIPT = "check_ddr2.tcl"

_SETTINGS = settings_template("""\
    # The clocks of the pins come first: the memory controller's own constraints build on them.
    set_global_assignment -name SDC_FILE {{name}}.sdc
    set_global_assignment -name QIP_FILE {{platform.MEMORY_CONTROLLER}}.qip
""", """
    # The two lines of the memory's clock are one differential pair.
    set_instance_assignment -name CKN_CK_PAIR ON -from ddr2_0__clk_n__io -to ddr2_0__clk__io
""")

_CONSTRAINTS = OUTSIDE_CLOCKS + """
    # Clocks of the display's PLL and of the one inside the memory controller.
    derive_pll_clocks
    derive_clock_uncertainty

    # The clock that is sent with the pixels of the monitor, inverted.
    create_generated_clock -name dvi_clock -source [get_pins {display_pll|auto_generated|pll1|clk[0]}] -invert [get_ports {dvi_0__clk__io}]

    # The four domains are asynchronous: what goes from one to another goes through asynchronous FIFOs and synchronisers. The oscillator
    # itself clocks nothing but the PLLs and what the memory controller starts up with: its constraints know of that. This comes last of
    # what concerns clocks: a filter finds no clock that is created later.
    # Monitor and cameras exchange nothing but resets, through synchronisers.
    set_clock_groups -asynchronous \\
        -group [get_clocks {display_pll|* dvi_clock}] \\
        -group [get_clocks {camera_0__clk__io}] \\
        -group [get_clocks {camera_1__clk__io}]
    # From and to the memory controller's clock, FIFOs have Gray pointers, whose bounds follow below. A path that clock groups or a false
    # path cut has no bound at all, so these clocks are not cut: what is not a pointer gets a wide bound.
    {% for command, value in (("set_max_delay", 100), ("set_min_delay", -100)) %}
    {{command}} -from [get_clocks {ddr2|*}] -to [get_clocks {display_pll|* camera_0__clk__io camera_1__clk__io}] {{value}}
    {{command}} -from [get_clocks {display_pll|* camera_0__clk__io camera_1__clk__io}] -to [get_clocks {ddr2|*}] {{value}}
    {% endfor %}

    # DVI: the transmitter TFP410 latches at the rising edge of its clock, which is the inverted pixel clock. It wants 1.2 ns of set-up and
    # 1.3 ns of hold; half a pixel is {{"%.1f"|format(5e8 / platform.display.pixel_clock_hz)}} ns.
    set dvi_ports [get_ports {dvi_0__red__io[*] dvi_0__green__io[*] dvi_0__blue__io[*] dvi_0__de__io dvi_0__hsync__io dvi_0__vsync__io}]
    set_output_delay -clock dvi_clock -max 1.2 $dvi_ports
    set_output_delay -clock dvi_clock -min -1.3 $dvi_ports

    # Cameras: BT.656 has the bytes change around the falling edge of their clock. 10 ns is what a sister of the decoder needs at most.
    {% for number in (0, 1) %}
    set_input_delay -clock camera_{{number}}__clk__io -clock_fall -max 10.0 [get_ports {camera_{{number}}__data__io[*]}]
    set_input_delay -clock camera_{{number}}__clk__io -clock_fall -min 0.0 [get_ports {camera_{{number}}__data__io[*]}]
    {% endfor %}

    # Levels that change slowly or never, and lines without a clock.
    set_false_path -from [get_ports {rst_0__io button_*__io switch_*__io uart_0__rx__io decoder_0__s*__io dvi_0__s*__io}]
    set_false_path -to [get_ports {led_*__io uart_0__tx__io decoder_0__*__io dvi_0__s*__io}]
    set_false_path -to [get_ports {dvi_0__clk_n__io dvi_0__isel__io dvi_0__power_up__io dvi_0__dken__io dvi_0__ctl__io[*]}]
"""


_GRAY_CONSTRAINTS = """
# Gray pointers of the FIFOs: all bits arrive within a window as wide as a period of the faster clock, relative to the clock that receives
# them; so at most one of them is on its way when it samples. Constraints on registers have priority over those on clocks.
"""

_PIXEL_CLOCK, _LOCAL_CLOCK, *_CAMERA_CLOCKS = "altpll.clk", f"{MEMORY_CONTROLLER}.phy_clk", "camera_0__clk__io", "camera_1__clk__io"

#: Source of a clock to the filter that finds it in the constraints.
_FILTERS = {_PIXEL_CLOCK: "display_pll|*", _LOCAL_CLOCK: "ddr2|*", **{port: port for port in _CAMERA_CLOCKS}}


class StereoPlatform(Cyclone3Platform):
    """The board with the files of this project.

    Parameters
    ----------
    display : DisplayFormat
    config : MatcherConfig
    local_clock_mhz : float
        Of the memory controller's local interface, half of the memory's.
    """
    MEMORY_CONTROLLER = MEMORY_CONTROLLER

    quartus_file_templates: ClassVar = file_templates(__package__, _CONSTRAINTS, _SETTINGS)

    def __init__(self, display: DisplayFormat, config: MatcherConfig, local_clock_mhz: float):
        super().__init__()
        self.display = display
        self.config = config
        self.local_clock_mhz = local_clock_mhz

    @property
    def display_ratio(self) -> Fraction:
        return pll_ratio(self.display.pixel_clock_hz)


def quartus_project(core: System, display: DisplayFormat, config: MatcherConfig) -> Project:
    """Verilog, project, settings, constraints and README of the board with ``core`` on it.

    Parameters
    ----------
    core : wiring.Component
        With the ports :class:`hdl.video.ports.SystemPorts`; its budget has the clock of the memory controller.
    display, config
        What the core was made for.
    """
    assert core.budget
    local_clock_mhz = core.budget.timing.clock_hz / 1e6
    files, netlist = emitted_files(StereoPlatform(display, config, local_clock_mhz), BoardTop(core, display), [ATTRIBUTE])
    generated = {_PIXEL_CLOCK: display.pixel_clock_hz / 1e6, _LOCAL_CLOCK: local_clock_mhz}
    clocks_mhz = {**generated, **dict.fromkeys(_CAMERA_CLOCKS, PAL.byte_clock_hz / 1e6)}
    files[f"{NAME}.sdc"] += _GRAY_CONSTRAINTS + gray_constraints(
        Hierarchy(netlist, NAME, BLOCKS), _FILTERS, {clock: 1000 / mhz for clock, mhz in clocks_mhz.items()})
    files[DDR2_SCRIPT] = _ddr2_script(netlist[NAME].cells["ddr2"])
    return Project(NAME, files, netlist, generated)


def _ddr2_script(controller: Cell) -> str:
    """The script with the ports that are connected to the memory controller."""
    ports = "\n".join(f"    {port} {len(bits)}" for port, bits in sorted(controller.connections.items()))
    text = resources.files(__package__).joinpath(DDR2_SCRIPT).read_text(encoding="utf-8")
    return text.replace("@MODULE@", controller.kind).replace("@PORTS@", ports)
