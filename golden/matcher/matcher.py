"""Results of a pair, whichever method the configuration has: the method's golden functions, found by its class."""

from collections.abc import Callable
from typing import Any

from numpy.typing import NDArray

from ..config import Fused, MatcherConfig, OnePass, Recursive
from . import fused, labelling
from .recursive import method as recursive


__all__ = ["MATCHERS", "disparities", "in_pixels", "match"]


Fields = dict[str, NDArray[Any]]


def _one_pass(left: NDArray[Any], right: NDArray[Any], config: MatcherConfig) -> Fields:
    return {"disparity": labelling.match(left, right, config)}


def _fields(result: fused.FusedMatch) -> Fields:
    return {"disparity": result.disparity, "passed": result.passed, "confidence": result.confidence}


def _fused(left: NDArray[Any], right: NDArray[Any], config: MatcherConfig) -> Fields:
    return _fields(fused.match(left, right, config))


def _recursive(left: NDArray[Any], right: NDArray[Any], config: MatcherConfig) -> Fields:
    return _fields(recursive.match(left, right, config))


#: Method to the function that gives its result's fields; a further method adds a row.
MATCHERS: dict[type, Callable[[NDArray[Any], NDArray[Any], MatcherConfig], Fields]] = {
    OnePass: _one_pass, Fused: _fused, Recursive: _recursive}


def match(left, right, config: MatcherConfig) -> Fields:
    """Result of the method of ``config`` for a rectified pair: the gateware's output words, field by field.

    Parameters
    ----------
    left, right : (H, W) integer ndarray
        Grey levels ``0..255``.

    Returns
    -------
    dict of str to (H, W) ndarray
        Names as in ``config.result_fields``; ``disparity`` in units of ``1 / config.method.disparity_scale`` pixel.
    """
    return MATCHERS[type(config.method)](left, right, config)


def in_pixels(disparity: NDArray[Any], config: MatcherConfig) -> NDArray[Any]:
    """Disparities of a result in pixels: as they are, or float64 with sub-pixel disparities, which it holds exactly."""
    scale = config.method.disparity_scale
    return disparity if scale == 1 else disparity / scale


def disparities(left, right, config: MatcherConfig):  # type: ignore[no-untyped-def]
    """Disparities of a rectified pair by :func:`match`, in pixels."""
    return in_pixels(match(left, right, config)["disparity"], config)
