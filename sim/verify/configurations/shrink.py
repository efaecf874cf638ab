"""From a case that fails to a smaller one that fails as well, until none of its parts can be left out or made smaller."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any, TypeVar

from golden.config import METHODS, value_of

from .case import Case, CaseFrame


__all__ = ["smaller", "smallest"]


Item = TypeVar("Item", Case, CaseFrame)


def _with(item: Item, name: str, value: Any) -> Item:
    changes: dict[str, Any] = {name: value}
    return replace(item, **changes)


def _less(value: int, least: int) -> Iterator[int]:
    """Smaller numbers to try: the least, half, one less."""
    yield from sorted({least, (value + least) // 2, value - 1} - {value} if value > least else set())


def _frames(frame: CaseFrame) -> Iterator[CaseFrame]:
    """Frames with less in them."""
    for name in ("stall_i", "stall_o", "burst_i", "burst_o"):
        if getattr(frame, name):
            yield _with(frame, name, 0)
    if frame.settings is not None:
        yield replace(frame, settings=None)
        for name in frame.settings:
            if len(frame.settings) > 1:
                yield replace(frame, settings={other: value for other, value in frame.settings.items() if other != name})
    for name in ("height", "width"):
        for value in _less(getattr(frame, name), 1):
            yield _with(frame, name, value)


def _with_labels(case: Case, labels: int) -> Case:
    """With so many labels, and no more of them in use."""
    frames = tuple(
        replace(frame, settings={**frame.settings, "in_use": min(frame.settings["in_use"], labels)})
        if frame.settings and "in_use" in frame.settings else frame for frame in case.frames)
    return replace(case, labels=labels, frames=frames, in_use=None if case.in_use is None else min(case.in_use, labels))


def _number(parameter: Any) -> bool:
    return isinstance(parameter, int) and not isinstance(parameter, bool)


def smaller(case: Case) -> Iterator[Case]:
    """Cases with less in them, those with the least first; not all of them need have a matcher."""
    frames = case.frames
    for number in range(len(frames)):
        if len(frames) > 1:
            yield replace(case, frames=frames[:number] + frames[number + 1:])
    for name, value in case.parameters.items():
        if name in _SIZES or value is False:
            continue    # the default is no less
        yield replace(case, parameters={other: value for other, value in case.parameters.items() if other != name})
    for name, default in (("in_use", None), ("minimum", 0)):
        if getattr(case, name) != default:
            yield _with(case, name, default)
    for labels in _less(case.labels, 2):
        yield _with_labels(case, labels)
    for number, frame in enumerate(frames):
        for less in _frames(frame):
            yield replace(case, frames=(*frames[:number], less, *frames[number + 1:]))
    longest = max(frame.width for frame in frames)
    for width in _less(case.max_width, longest):
        yield replace(case, max_width=width)
    # A stage off, and the least of what sets the size of the gateware.
    method = METHODS[case.method]
    for name in getattr(method, "SWITCHES", {}):
        if case.parameters.get(name, value_of(method(), name)):
            yield replace(case, parameters={**case.parameters, name: False})
    for name, limits in getattr(method, "LIMITS", {}).items():
        value = case.parameters.get(name, value_of(method(), name))
        if name in _SIZES and _number(value) and value > limits[0]:
            yield replace(case, parameters={**case.parameters, name: limits[0]})


# Parameters that the gateware grows with.
_SIZES = ("reach", "fan", "census_rows", "census_columns")


def smallest(case: Case, fails: Callable[[Case], bool], runs: int = 60) -> Case:
    """The smallest case that ``fails`` which greedy steps from ``case`` reach within so many runs."""
    seen = [case]
    while True:
        for candidate in smaller(case):
            if candidate in seen:
                continue
            try:
                _ = candidate.configs()
            except ValueError:      # no such matcher
                continue
            if len(seen) > runs:
                return case
            seen.append(candidate)
            if fails(candidate):
                case = candidate
                break
        else:
            return case
