"""A page of `python -m hdl.resources.tables`, in small."""

__all__ = ["RESOURCES"]


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
