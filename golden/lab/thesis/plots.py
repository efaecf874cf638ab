"""Pictures of the pages, as PNG data: panels of pictures, curves, a map of numbers."""

import io
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...pictures.sheet import small


__all__ = ["curves", "heat", "panels"]


WIDTH = 9.0  # inches
DPI = 90


def _png(figure: Any) -> bytes:
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=DPI, metadata={"Software": None})  # the same bytes from the same numbers
    return small(buffer.getvalue())


def panels(pictures: Sequence[tuple[str, NDArray[Any], int | None]], columns: int) -> bytes:
    """Pictures in a grid, each under its title.

    Parameters
    ----------
    pictures : sequence of (str, ndarray, int or None)
        Title; (H, W) grey levels, (H, W, 3) colours, or (H, W) disparities, not finite where unknown, which is black; for disparities
        the greatest of the colour scale, otherwise ``None``.
    columns : int
    """
    from matplotlib import colormaps  # here, because it takes longer to load than all the rest
    from matplotlib.figure import Figure

    rows = -(-len(pictures) // columns)
    ratio = max(picture.shape[0] / picture.shape[1] for _, picture, _ in pictures)
    figure = Figure(figsize=(WIDTH, rows * (WIDTH / columns * ratio + 0.3)), layout="constrained")
    viridis = colormaps["viridis"].with_extremes(bad="black")
    all_axes = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes in all_axes:
        axes.set_axis_off()
    for axes, (title, picture, greatest) in zip(all_axes, pictures, strict=False):
        if greatest is not None:
            axes.imshow(np.ma.masked_invalid(picture), cmap=viridis, vmin=0, vmax=greatest, interpolation="nearest")
        elif picture.ndim == 3:
            axes.imshow(picture, interpolation="nearest")
        else:
            axes.imshow(picture, cmap="gray", vmin=0, vmax=255)
        axes.set_title(title, fontsize=9)
    return _png(figure)


def curves(graphs: Sequence[tuple[str, dict[str, tuple[Sequence[float], Sequence[float]]]]], x: str, y: str, columns: int = 2,
           dashed: Mapping[str, str] | None = None) -> bytes:
    """Graphs side by side, each a title and its curves by name: x and y.

    Parameters
    ----------
    graphs : sequence of (str, dict)
    x, y : str
        What the axes show.
    columns : int
    dashed : dict of str to str, or None
        Curves that are dashed, each in the colour of another one, which stands before it in every graph.
    """
    from matplotlib.figure import Figure

    rows = -(-len(graphs) // columns)
    figure = Figure(figsize=(WIDTH, rows * WIDTH / max(columns, 2) * 0.7), layout="constrained")
    all_axes = figure.subplots(rows, columns, squeeze=False)
    for axes in all_axes.flat[len(graphs):]:
        axes.set_axis_off()
    for axes, (title, lines) in zip(all_axes.flat, graphs, strict=False):
        colours: dict[str, str] = {}
        for name, (xs, ys) in lines.items():
            style = {"linestyle": "--", "color": colours[dashed[name]]} if dashed and name in dashed else {}
            (line,) = axes.plot(xs, ys, marker=".", label=name, **style)
            colours[name] = line.get_color()
        axes.set_title(title, fontsize=10)
        axes.set(xlabel=x, ylabel=y, ylim=(0, None))
        axes.legend(fontsize=8)
        axes.grid(alpha=0.3)
    return _png(figure)


def heat(maps: Sequence[tuple[str, NDArray[np.float64]]], ticks: Sequence[int], x: str, y: str) -> bytes:
    """Maps of numbers side by side, each with a colour scale of its range: dark is low."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(WIDTH, WIDTH / len(maps) * 0.85), layout="constrained")
    for axes, (title, values) in zip(figure.subplots(1, len(maps), squeeze=False).flat, maps, strict=True):
        shown = axes.imshow(values, cmap="viridis", origin="lower")
        figure.colorbar(shown, ax=axes, shrink=0.8)
        axes.set_xticks(range(len(ticks)), [str(tick) for tick in ticks])
        axes.set_yticks(range(len(ticks)), [str(tick) for tick in ticks])
        axes.set_title(title, fontsize=10)
        axes.set(xlabel=x, ylabel=y)
    return _png(figure)
