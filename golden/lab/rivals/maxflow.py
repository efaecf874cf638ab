"""The exact minimum cut of one scanline (thesis, section 2.1 and appendix A), and the energy that it minimises."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...config import Arithmetic, MatcherConfig, OnePass
from ...matcher.labelling import slopes


__all__ = ["LineGraph", "augmenting_path", "cut_labels", "line_energy", "line_graph", "line_terms", "push_relabel"]


Ints = NDArray[np.int64]
Cut = tuple[int, NDArray[np.bool_]]


def line_terms(cost: NDArray[Any], left: NDArray[Any], labels: NDArray[Any], local: NDArray[Any], y: int,
               config: MatcherConfig) -> tuple[Ints, Ints]:
    """Terms of the energy that the one-pass rule (2-15) minimises along line ``y``, given the labels of the lines above and below.

    Parameters
    ----------
    cost : (H, W, D) ndarray
        Of :func:`golden.matcher.cost.matching_cost`.
    left : (H, W) integer ndarray
        Grey levels.
    labels, local : (H, W) integer ndarray
        Of the rule, for the upper neighbour; local disparities, for the lower one.
    y : int
    config : MatcherConfig
        ``LINEAR`` arithmetic, cost ``THESIS``: whole energies, linear in the distance of the labels.

    Returns
    -------
    data : (W, D) int64 ndarray
        ``E`` with the smoothness against the upper and the lower neighbour.
    weight : (W-1,) int64 ndarray
        Smoothness of a pixel of disparity between ``x`` and ``x + 1``.
    """
    if config.method_as(OnePass).arithmetic is not Arithmetic.LINEAR:
        raise ValueError(f"lines are cut in the arithmetic linear only, not {config.method.arithmetic}")
    rows = slice(max(y - 1, 0), y + 2)  # slopes read one line above and one below
    w1, w2, w3 = slopes(np.asarray(left)[rows], config)[:, y - rows.start].astype(np.int64)
    label = np.arange(cost.shape[-1])
    data = cost[y].astype(np.int64) * config.rule.energy_scale
    for weight, neighbours, number in ((w2, labels, y - 1), (w3, local, y + 1)):
        if 0 <= number < len(cost):
            data += weight[:, None] * np.abs(label - np.asarray(neighbours)[number, :, None])
    return data, w1[1:]


def line_energy(labels: NDArray[Any], data: Ints, weight: Ints) -> int:
    """Energy of a line's labels: their data terms, and ``weight * |difference|`` between neighbours."""
    labels = np.asarray(labels, dtype=np.int64)
    return int(data[np.arange(labels.size), labels].sum() + (weight * np.abs(np.diff(labels))).sum())


@dataclass(frozen=True)
class LineGraph:
    """The thesis's row-column graph: a row of vertices for every pixel of a line, a column for every step between two disparities.

    Vertex ``x * (D-1) + k`` is between the disparities ``k`` and ``k+1`` of pixel ``x``; on the source's side it means that the
    disparity is greater than ``k``. A cut severs one t-link of every row, that of the disparity, and the n-links between.

    Parameters
    ----------
    shape : (int, int)
        Rows and columns, ``W`` and ``D-1``.
    from_source, to_sink : (W,) ndarray
        Capacities of the first and of the last t-link of every row.
    tails, heads : (M,) ndarray
        Vertices of the other links.
    forward, backward : (M,) ndarray
        Their capacities, from tail to head and back.
    """
    shape: tuple[int, int]
    from_source: Ints
    to_sink: Ints
    tails: Ints
    heads: Ints
    forward: Ints
    backward: Ints

    @property
    def vertices(self) -> Ints:
        """Numbers of the vertices, (W, D-1)."""
        return np.arange(self.shape[0] * self.shape[1]).reshape(self.shape)


def line_graph(data: Ints, weight: Ints) -> LineGraph:
    """The graph whose minimum cut is the least :func:`line_energy`.

    Parameters
    ----------
    data : (W, D) int64 ndarray
        From 0; at least two disparities.
    weight : (W-1,) int64 ndarray
        From 0.
    """
    width, labels = data.shape
    shape = width, labels - 1
    vertex = np.arange(width * (labels - 1)).reshape(shape)
    # As in the thesis's figure there are no links back along a row, so a cut might sever two t-links of a row. No such cut is minimal: it
    # would sever a pixel's t-links twice, where all columns of n-links cost the same.
    along, between = data[:, 1:-1], np.repeat(weight, labels - 1)
    return LineGraph(
        shape, data[:, 0], data[:, -1],
        tails=np.concatenate([vertex[:, :-1].ravel(), vertex[:-1].ravel()]),
        heads=np.concatenate([vertex[:, 1:].ravel(), vertex[1:].ravel()]),
        forward=np.concatenate([along.ravel(), between]), backward=np.concatenate([np.zeros_like(along.ravel()), between]))


def augmenting_path(graph: LineGraph) -> Cut:
    """Maximum flow by augmenting paths: Boykov and Kolmogorov's search trees, of PyMaxflow.

    Returns
    -------
    flow : int
    source : (W, D-1) bool ndarray
        The vertices on the source's side of a minimum cut.
    """
    import maxflow  # here, because only the rivals need it

    vertex = graph.vertices
    solver = maxflow.GraphInt(vertex.size, graph.tails.size)
    solver.add_nodes(vertex.size)
    solver.add_edges(graph.tails, graph.heads, graph.forward, graph.backward)
    # With two disparities, a vertex is first and last of its row.
    first, last = np.zeros(graph.shape, dtype=np.int64), np.zeros(graph.shape, dtype=np.int64)
    first[:, 0], last[:, -1] = graph.from_source, graph.to_sink
    solver.add_grid_tedges(vertex, first, last)
    flow = solver.maxflow()
    return int(flow), ~solver.get_grid_segments(vertex)


def push_relabel(graph: LineGraph) -> Cut:
    """Maximum flow by push-relabel, of OR-Tools; returns as :func:`augmenting_path`."""
    from ortools.graph.python.max_flow import SimpleMaxFlow  # here, because only the rivals need it

    vertex = graph.vertices
    source, sink = vertex.size, vertex.size + 1
    solver = SimpleMaxFlow()
    for tails, heads, capacities in (
            (np.full(len(vertex), source), vertex[:, 0], graph.from_source), (vertex[:, -1], np.full(len(vertex), sink), graph.to_sink),
            (graph.tails, graph.heads, graph.forward), (graph.heads, graph.tails, graph.backward)):
        solver.add_arcs_with_capacity(tails, heads, capacities)
    status = solver.solve(source, sink)
    if status != solver.OPTIMAL:
        raise ArithmeticError(f"OR-Tools found no maximum flow: {status}")
    side = np.zeros(sink + 1, dtype=bool)
    side[solver.get_source_side_min_cut()] = True
    return int(solver.optimal_flow()), side[:source].reshape(graph.shape)


def cut_labels(source: NDArray[np.bool_]) -> Ints:
    """Disparities of a cut: in every row, the number of vertices on the source's side."""
    return source.sum(axis=1, dtype=np.int64)
