"""A chip with rectifiers at the other end of a line, for tests of the console: strict about what is loaded, and when."""

import contextlib

from golden.config import MatcherConfig
from golden.host.protocol import decode_request, encode_reply
from golden.host.registers import Kind, answer, register_map
from golden.rig.config import RigConfig
from golden.rig.maps import identity, map_sum, pack, word_count


class RigChip:
    """Registers, both maps of both cameras, and pairs of pictures that are received every ``pair_requests`` requests; none if 0.

    ``fault`` takes the number of the request, counted from 0, and the reply's bytes, and returns bytes. ``lost`` tells by number and name
    whether a request is not received at all. ``flip`` is a bit of the word with this number, of those that are written, that is wrong in
    the memory.

    Attributes
    ----------
    in_use : list of list of int
        Words of the map of each side that pictures are rectified with.
    swaps : int
        How often other maps were put in use.
    failures : list of str
        What must never be done.
    """
    LOADING = frozenset(("map_side", "map_address", "map_low", "map_middle", "map_high", "map_start", "map_next", "map_swap", "row_offset"))

    def __init__(self, width=40, height=33, lines=34, *, pair_requests=3, fault=lambda number, data: data,
                 lost=lambda number, name: False, flip=()):
        self.registers = register_map(MatcherConfig(labels=20, max_width=width), height, RigConfig(lines) if lines else None)
        self.values = {"map": 0}
        self.pair_requests = pair_requests
        self.fault, self.lost = fault, lost
        self.flip = {*flip}
        count = word_count(width, height)
        self._memory = [[pack(identity(width, height)) + [0] * ((1 << (count - 1).bit_length()) - count) for _ in range(2)]
                        for _ in range(2)]
        self._count = count
        self._bank, self._place, self._written, self._summed = 0, 0, 0, []
        self.swaps = 0
        self.faulty = False     # pairs are not rectified to their end
        self.names = []
        self.failures = []
        self._data = b""

    @property
    def in_use(self):
        return [side[self._bank][:self._count] for side in self._memory]

    def connect(self, port, baud):
        return contextlib.nullcontext(self)

    def write(self, data):
        number, request = len(self.names), decode_request(data)
        register = self.registers.at(request.address)
        self.names.append(register.name)
        if self.pair_requests and number % self.pair_requests == 0:
            self._pair()
        if self.lost(number, register.name):
            return
        reply, written = answer(self.registers, self.values, data)
        for name, value in written.items():
            self._carry_out(name, value)
        self._data += self.fault(number, encode_reply(reply))

    def read(self, count, seconds):
        data, self._data = self._data[:count], self._data[count:]
        return data

    def _pair(self):
        if self.values.get("map_swapping"):
            self._bank ^= 1
            self.swaps += 1
            self.values |= {"map_swapping": 0, "map": 2}
        if self.faulty:
            self.values |= {"map_fault": 1, "map_abandoned": min(self.values.get("map_abandoned", 0) + 1, 255)}

    def _carry_out(self, name, value):
        if name in self.LOADING and name != "map_swap" and self.values.get("map_swapping"):
            self.failures.append(f"{name} is written while maps wait")
        if self.registers[name].kind is Kind.SETTING:
            self.values[name] = value
        elif name == "map_start":
            self._place, self._summed = self.values.get("map_address", 0), []
        elif name == "map_next":
            low, middle, high = (self.values.get(part, 0) for part in ("map_low", "map_middle", "map_high"))
            word = low | middle << 16 | high << 32
            # A wrong bit is wrong before the sum.
            word ^= self._written in self.flip
            memory = self._memory[self.values.get("map_side", 0)][1 - self._bank]
            memory[self._place % len(memory)] = word
            self._place, self._written = self._place + 1, self._written + 1
            self._summed.append(word)
        elif name == "map_swap":
            self.values["map_swapping"] = 1
        self.values["map_sum"] = map_sum(self._summed)
