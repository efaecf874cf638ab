"""The cocotb half of ``test_system.py``."""

import time

import cocotb

from golden.display import DisplayMode
from sim.system_rig import Rig


@cocotb.test()
async def pictures(dut):
    """From two cameras to the monitor, bit-exact; what the host sets takes effect, for whole pictures."""
    rig = Rig(dut)
    await rig.start()
    t=time.time()
    await rig.shows(frames=20)
    dut._log.info("first %g s %d clocks", time.time()-t, rig.memory.now)
    rig.change()
    await rig.shows()
    dut._log.info("second %g s %d clocks", time.time()-t, rig.memory.now)
    await rig.write("show", 1)
    dut._log.info("write %g s %d clocks", time.time()-t, rig.memory.now)
    rig.change(mode=DisplayMode.LEFT)
    await rig.shows()
    dut._log.info("third %g s %d clocks", time.time()-t, rig.memory.now)
