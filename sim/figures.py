"""The figures of a run, of the simulator or of a board: what both report, and their table on stdout."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from rich.table import Table

from golden.cli import described
from golden.config import MatcherConfig
from golden.tables import print_table


__all__ = ["common_report", "print_figures"]


def common_report(config: MatcherConfig, height: int, width: int, clocks: int, wrong: int) -> dict[str, Any]:
    """Figures of a frame of ``height x width`` pixels that either matched: its configuration, its clocks, and the pixels that differ."""
    return {"method": config.method.name, "arithmetic": str(config.method.arithmetic), "method_parameters": config.method.about(),
            "minimum": config.minimum, "width": width, "height": height, "disparities": config.labels,
            "mismatches": wrong, "clocks": clocks}


def print_figures(report: dict[str, Any], config: MatcherConfig, where: str, rows: Iterable[tuple[str, str]], folder: Path) -> None:
    """Print the size, ``where`` it was matched, mismatches, the ``rows`` between and the accuracy if known; then where the results are."""
    table = Table()
    table.add_column("figure")
    table.add_column("value", justify="right")
    table.add_row("mismatching pixels against golden", f"{report['mismatches']}")
    for name, value in rows:
        table.add_row(name, value)
    if "passed_percent" in report:
        table.add_row("pixels that pass the left-right check", f"{report['passed_percent']:.0f} %")
    if "bad_pixels_percent" in report:
        table.add_row("bad pixels, error above 1 pixel", f"{report['bad_pixels_percent']:.2f} %")
    print(f"{report['width']}x{report['height']} pixels, {report['disparities']} disparities, {described(config)}, {where}:")
    print_table(table)
    print(f"Results are in {folder}: disparity.png to look at, report.json for the figures.")
