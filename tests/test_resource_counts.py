"""Counts of small matchers, exact and per block: better or worse, a change is written down.

``python -m tests.test_resource_counts`` prints what to put here.
"""

import pytest

from golden.config import Arithmetic, Engine, MatcherConfig
from hdl.matcher import Matcher
from hdl.resources.count import Resources, count
from hdl.resources.mapping import map_cyclone3


CONFIGS = {
    "sequential thesis": MatcherConfig(disparities=6, max_width=64),
    "sequential linear": MatcherConfig(disparities=6, max_width=64, arithmetic=Arithmetic.LINEAR),
    "streaming linear": MatcherConfig(disparities=6, max_width=64, arithmetic=Arithmetic.LINEAR, engine=Engine.STREAMING),
}

# Logic elements, memory bits, M9K blocks, 9x9 multipliers, without those of the blocks inside.
COUNTS: dict[str, dict[str, tuple[int, int, int, int]]] = {
    "sequential thesis": {
        "matcher": (63, 0, 0, 0),
        "matcher.bec": (5, 0, 0, 0),
        "matcher.bec.buffers": (265, 0, 0, 0),
        "matcher.bec.comparison": (176, 0, 0, 0),
        "matcher.bec.cost_energy": (795, 0, 0, 0),
        "matcher.bec.edata": (349, 0, 0, 0),
        "matcher.bec.sub_pixels": (147, 0, 0, 0),
        "matcher.engine": (92, 192, 1, 0),
        "matcher.engine.comparison": (194, 0, 0, 0),
        "matcher.engine.edata_memory": (1, 5248, 3, 0),
        "matcher.engine.smooth1": (54, 0, 0, 6),
        "matcher.engine.smooth1.look_up_table": (93, 324, 2, 0),
        "matcher.engine.smooth2": (54, 0, 0, 6),
        "matcher.engine.smooth2.look_up_table": (96, 324, 2, 0),
        "matcher.engine.smooth3": (54, 0, 0, 6),
        "matcher.engine.smooth3.look_up_table": (96, 324, 2, 0),
        "matcher.engine.summation": (204, 0, 0, 0),
        "matcher.line_store": (77, 2048, 2, 0),
        "matcher.line_store.column": (55, 0, 0, 0),
        "matcher.line_store.plus_fifo": (50, 589, 1, 0),
        "matcher.line_store.plus_register": (1, 0, 0, 0),
    },
    "sequential linear": {
        "matcher": (60, 0, 0, 0),
        "matcher.bec": (4, 0, 0, 0),
        "matcher.bec.buffers": (293, 0, 0, 0),
        "matcher.bec.comparison": (191, 0, 0, 0),
        "matcher.bec.cost_energy": (892, 0, 0, 0),
        "matcher.bec.edata": (379, 0, 0, 0),
        "matcher.bec.sub_pixels": (147, 0, 0, 0),
        "matcher.engine": (108, 192, 1, 0),
        "matcher.engine.comparison": (254, 0, 0, 0),
        "matcher.engine.edata_memory": (1, 5632, 3, 0),
        "matcher.engine.smooth1": (425, 0, 0, 0),
        "matcher.engine.smooth2": (429, 0, 0, 0),
        "matcher.engine.smooth3": (421, 0, 0, 0),
        "matcher.engine.summation": (258, 0, 0, 0),
        "matcher.line_store": (77, 2048, 2, 0),
        "matcher.line_store.column": (54, 0, 0, 0),
        "matcher.line_store.plus_fifo": (50, 589, 1, 0),
        "matcher.line_store.plus_register": (1, 0, 0, 0),
    },
    "streaming linear": {
        "matcher": (51, 0, 0, 0),
        "matcher.engine": (207, 704, 2, 0),
        "matcher.engine.address_delay": (29, 0, 0, 0),
        "matcher.engine.array": (18, 0, 0, 0),
        "matcher.engine.array.align_0_1": (3, 0, 0, 0),
        "matcher.engine.array.align_0_2": (6, 0, 0, 0),
        "matcher.engine.array.align_0_3": (9, 0, 0, 0),
        "matcher.engine.array.align_0_4": (12, 0, 0, 0),
        "matcher.engine.array.align_5": (24, 0, 0, 0),
        "matcher.engine.array.down_0": (35, 0, 0, 0),
        "matcher.engine.array.down_1": (65, 0, 0, 0),
        "matcher.engine.array.down_2": (76, 0, 0, 0),
        "matcher.engine.array.down_3": (76, 0, 0, 0),
        "matcher.engine.array.down_4": (77, 0, 0, 0),
        "matcher.engine.array.down_5": (61, 0, 0, 0),
        "matcher.engine.array.down_delay": (4, 115, 1, 0),
        "matcher.engine.array.up_0": (117, 0, 0, 0),
        "matcher.engine.array.up_1": (137, 0, 0, 0),
        "matcher.engine.array.up_2": (137, 0, 0, 0),
        "matcher.engine.array.up_3": (95, 0, 0, 0),
        "matcher.engine.array.up_4": (68, 0, 0, 0),
        "matcher.engine.array.up_5": (53, 0, 0, 0),
        "matcher.engine.array.wait_0": (4, 128, 1, 0),
        "matcher.engine.array.wait_1": (4, 108, 1, 0),
        "matcher.engine.array.wait_2": (3, 76, 1, 0),
        "matcher.engine.array.wait_3": (72, 0, 0, 0),
        "matcher.engine.array.wait_4": (38, 0, 0, 0),
        "matcher.engine.bec": (61, 7344, 3, 0),
        "matcher.engine.bec.group_0": (244, 0, 0, 0),
        "matcher.engine.bec.group_0.label_0": (170, 0, 0, 0),
        "matcher.engine.bec.group_0.label_1": (170, 0, 0, 0),
        "matcher.engine.bec.group_0.label_2": (170, 0, 0, 0),
        "matcher.engine.bec.group_0.label_3": (170, 0, 0, 0),
        "matcher.engine.bec.group_4": (90, 0, 0, 0),
        "matcher.engine.bec.group_4.label_4": (170, 0, 0, 0),
        "matcher.engine.bec.group_4.label_5": (170, 0, 0, 0),
        "matcher.engine.bec.skew_1": (12, 0, 0, 0),
        "matcher.engine.bec.skew_2": (24, 0, 0, 0),
        "matcher.engine.bec.skew_3": (36, 0, 0, 0),
        "matcher.engine.bec.skew_5": (12, 0, 0, 0),
        "matcher.engine.bec.store_delay": (4, 0, 0, 0),
        "matcher.engine.beside": (29, 154, 1, 0),
        "matcher.engine.cones": (816, 0, 0, 0),
        "matcher.engine.cones.beside": (74, 0, 0, 0),
        "matcher.engine.cones.down_step": (20, 0, 0, 0),
        "matcher.engine.cones.ramp": (33, 0, 0, 0),
        "matcher.engine.cones.vertices": (49, 0, 0, 0),
        "matcher.engine.cones.weights_delay": (36, 0, 0, 0),
        "matcher.engine.head": (1, 0, 0, 0),
        "matcher.engine.output": (55, 216, 1, 0),
        "matcher.engine.queue": (48, 552, 1, 0),
        "matcher.engine.source": (142, 0, 0, 0),
        "matcher.engine.turn": (20, 260, 1, 0),
        "matcher.line_store": (85, 2048, 2, 0),
        "matcher.line_store.column": (55, 0, 0, 0),
        "matcher.line_store.plus_fifo": (50, 589, 1, 0),
        "matcher.line_store.plus_register": (1, 0, 0, 0),
    },
}


def blocks_of(config):
    return count(map_cyclone3(Matcher(config), "matcher")).blocks


@pytest.mark.parametrize("name", CONFIGS)
def test_counts(name):
    assert blocks_of(CONFIGS[name]) == {block: Resources(*figures) for block, figures in COUNTS[name].items()}


if __name__ == "__main__":
    for name, config in CONFIGS.items():
        print(f'    "{name}": {{')
        for block, figures in blocks_of(config).items():
            print(f'        "{block}": {tuple(figures)},')
        print("    },")
