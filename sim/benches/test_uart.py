"""The registers behind their serial line as emitted Verilog, through cocotb on Icarus; see ``uart_tb.py``."""

from golden.host.protocol import BAUD
from golden.host.registers import register_map
from hdl.emit import write_verilog
from hdl.host.registers import SerialRegisters
from sim.kit.simulators import build, run


BIT_CYCLES = 16
FRAME_BITS = 30

# Benches in uart_tb.py: one at three rates, one.
TESTS = 3 + 1


def test_serial_registers(tmp_path):
    dut = SerialRegisters(register_map(), BIT_CYCLES * BAUD, frame_seconds=FRAME_BITS / BAUD)
    source = write_verilog(dut, tmp_path / "serial.v", name="serial_registers")
    build("icarus", [source], "serial_registers", tmp_path / "icarus")
    ran = run("icarus", "serial_registers", tmp_path / "icarus", "sim.benches.uart_tb",
              env={"BIT_CYCLES": BIT_CYCLES, "FRAME_BITS": FRAME_BITS})
    assert ran == TESTS
