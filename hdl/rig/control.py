"""What the host sets of rectification and balance, held from a pair's start to the next one's."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from golden.rig.config import MapsInUse
from golden.rig.rectify import ROW_OFFSETS

from .balance import BalanceMode


__all__ = ["ROWS", "RigControl", "RigSettings"]


#: A row offset.
ROWS = signed(len(ROW_OFFSETS).bit_length() - 1)


class RigSettings(data.StructLayout):
    """What a pair is rectified and balanced with, as members of :class:`hdl.rig.stages.RigStages`."""
    def __init__(self) -> None:
        super().__init__({"rectify": 1, "balance": BalanceMode, "fixed_gain": 10, "fixed_offset": signed(16), "minimum": signed(9)})


class RigControl(wiring.Component):
    """Settings of rectification and balance from one pair's ``start`` on, and which maps are in use.

    A ``swap`` waits for the next ``start``. With it the row offset changes that the reader applies to the right picture: maps and row
    offset belong together. Where pictures are not rectified, the row offset is 0.

    Golden: :meth:`golden.rig.files.Rig.rectified` for each pair.

    Timing: ``row_offset`` is that of the pair that starts in the same cycle, as ``start`` samples it; ``held`` changes in the cycle after.
    ``stages_swap`` is high in the cycle of ``start``.

    Parameters
    ----------
    built_in : bool
        The maps after configuration are those of a rig, not the identity.
    row_offset : int
        That belongs to them.

    Members
    -------
    settings : In(RigSettings()), wanted_row_offset : In(signed(8)), swap : In(1)
        From the host.
    start : In(1)
        A pair starts.
    swapping : In(1), stages_swap : Out(1)
        From and to the rectifier.
    held : Out(RigSettings()), row_offset : Out(signed(8))
    waits : Out(1)
        Maps that were written are not in use yet.
    maps : Out(MapsInUse)
        A reset changes neither the maps nor this.
    """
    def __init__(self, *, built_in: bool = False, row_offset: int = 0):
        if row_offset not in ROW_OFFSETS:
            raise ValueError(f"a row offset must be from {ROW_OFFSETS[0]} to {ROW_OFFSETS[-1]}, not {row_offset!r}")
        self.built_in = built_in
        self.first_row_offset = row_offset
        super().__init__({
            "settings": In(RigSettings()), "wanted_row_offset": In(ROWS), "swap": In(1), "start": In(1), "swapping": In(1),
            "stages_swap": Out(1), "held": Out(RigSettings()), "row_offset": Out(ROWS), "waits": Out(1), "maps": Out(MapsInUse),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        pending = Signal()
        offset  = Signal(ROWS, init=self.first_row_offset, reset_less=True)     # that belongs to the maps in use
        first = MapsInUse.BUILT_IN if self.built_in else MapsInUse.IDENTITY
        maps  = Signal(MapsInUse, init=first, reset_less=True)
        after = Mux(pending, self.wanted_row_offset, offset)
        m.d.comb += [
            self.stages_swap.eq(self.start & pending), self.waits.eq(pending | self.swapping), self.maps.eq(maps),
            self.row_offset.eq(Mux(self.settings.rectify, after, 0)),
        ]
        with m.If(self.start):
            m.d.sync += [self.held.eq(self.settings), offset.eq(after), pending.eq(0)]
            with m.If(pending):
                m.d.sync += maps.eq(MapsInUse.LOADED)
        with m.If(self.swap):
            m.d.sync += pending.eq(1)
        return m
