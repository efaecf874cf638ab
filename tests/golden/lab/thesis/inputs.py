"""What other commands write and the thesis pages read: the rivals' figures, the tables of resources."""

__all__ = ["RESOURCES", "RIVALS"]


RIVALS = {"methods": {
    "scan": {"about": "a scan", "published": "Dynamic Programming", "pairs": {
        "tsukuba": {"figures": {"nonocc": 4, "all": 5.5, "disc": 12}, "seconds": 1}}},
    "sgm": {"about": "semi-global", "pairs": {"tsukuba": {"figures": {"nonocc": 3, "all": 4, "disc": 9}, "seconds": 0.1, "energy": 7}}},
}}

RESOURCES = """\
# Tables 2 and 3

## Table 2: resources

| EP3C120 | available | thesis 720x576x80 | sequential 384x288x16 | sequential 720x576x80 | streaming 720x576x80 |
| --- | ---: | ---: | ---: | ---: | ---: |
| logic elements | 119,088 | 66,123 | 9,000 | 60,123 | 90,000 |
| DSP | 576 | - | 1 | 2 | 3 |

## Table 3: rate

Words.

| hardware | frames/s |
| --- | ---: |
| Virtex | 60 |

## Other

| no | table |
| --- | --- |
| a | b |
"""
