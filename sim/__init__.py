"""Simulation of the emitted Verilog: the commands ``run``, ``demo``, ``evaluate``, ``bench``, ``loop`` and ``system``, on pictures or with
the whole board. The rooms: ``kit`` drives simulators and checks streams, ``models`` are the chips around the FPGA, ``benches`` the tests.
May import ``golden``, ``hdl`` and ``boards``.
"""

from golden.errors import guard_start


guard_start()
