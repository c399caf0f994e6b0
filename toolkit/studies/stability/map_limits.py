"""Maps in words: where each is stable, and what happens first beyond."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import groupby
from typing import Literal, NamedTuple

from toolkit.studies.stability.classifier import CellClass
from toolkit.studies.stability.map import Axis
from toolkit.studies.stability.map_result import Cell, MapResult

Of = Literal["run", "gradient"]


class Breakdown(NamedTuple):
    """The first cell that is not stable, on the way from the scene's own place in one direction of one axis."""

    place: str
    of: Of
    verdict: CellClass


def verdicts(mapped: MapResult, of: Of) -> dict[tuple[int, ...], CellClass]:
    """Names of all cells that have one, of the run or of its gradient."""
    found = {at: _verdict(cell, of) for at, cell in mapped.cells.items()}
    return {at: verdict for at, verdict in found.items() if verdict is not None}


def _verdict(cell: Cell, of: Of) -> CellClass | None:
    return cell.run if of == "run" else cell.gradient


def mapped_range(mapped: MapResult) -> str:
    """What the map covers."""
    return "; ".join(
        _all(axis)
        if isinstance(axis.values[0], str)
        else f"{axis.name} {axis.long_label(0)} to {axis.long_label(len(axis.values) - 1)}"
        for axis in mapped.map.axes
    )


def _all(axis: Axis) -> str:
    return ", ".join(axis.label(k) for k in range(len(axis.values)))


def stable_where(mapped: MapResult, of: Of) -> str:
    """Ranges of the first axis where all is stable, for every row of the second; rows that are alike are put together."""
    names = {at: verdict.name for at, verdict in verdicts(mapped, of).items()}
    if not names:
        return "-"
    first, *second = mapped.map.axes
    if not second:
        return _ranges(first, [names[k,] for k in range(len(first.values))])
    rows = [_ranges(first, [names[k, row] for k in range(len(first.values))]) for row in range(len(second[0].values))]
    if len(set(rows)) == 1:
        return rows[0]
    return "; ".join(f"{second[0].name} {_span(second[0], group)}: {text}" for text, group in _alike(rows))


def _alike(rows: Sequence[str]) -> Iterator[tuple[str, list[int]]]:
    """Neighbouring rows with the same text."""
    for text, group in groupby(range(len(rows)), key=lambda row: rows[row]):
        yield text, list(group)


def _span(axis: Axis, numbers: Sequence[int]) -> str:
    return axis.label(numbers[0]) if len(numbers) == 1 else f"{axis.label(numbers[0])} to {axis.label(numbers[-1])}"


def _ranges(axis: Axis, names: Sequence[str]) -> str:
    """Stable stretches of one row; cells that were not run do not end "all" of those that were."""
    found = [list(group) for name, group in groupby(range(len(names)), key=lambda k: names[k] == "stable") if name]
    if not found:
        return "nowhere"
    if sum(map(len, found)) == sum(name != "not run" for name in names):
        return "all" if "not run" not in names else f"all that ran: {', '.join(_stretch(axis, each) for each in found)}"
    return ", ".join(_stretch(axis, each) for each in found)


def _stretch(axis: Axis, numbers: Sequence[int]) -> str:
    last = len(axis.values) - 1
    if isinstance(axis.values[0], str) or len(numbers) == 1:
        return ", ".join(axis.long_label(k) for k in numbers)
    if numbers[0] == 0:
        return f"up to {axis.long_label(numbers[-1])}"
    if numbers[-1] == last:
        return f"from {axis.long_label(numbers[0])}"
    return f"{axis.long_label(numbers[0])} to {axis.long_label(numbers[-1])}"


def breakdowns(mapped: MapResult) -> list[Breakdown]:
    """What happens first when one leaves the scene's own place along each axis; of the gradient only where the run still is stable."""
    axes = mapped.map.axes
    if any(axis.own is None for axis in axes):
        return []
    own = tuple(axis.own or 0 for axis in axes)
    runs, gradients = verdicts(mapped, "run"), verdicts(mapped, "gradient")
    found = []
    for number, axis in enumerate(axes):
        for direction in (-1, 1):
            way = [
                (*own[:number], k, *own[number + 1 :])
                for k in range(own[number], len(axis.values) if direction > 0 else -1, direction)
            ]
            run, gradient = _first(way, runs), _first(way, gradients)
            if gradient is not None and (run is None or way.index(gradient) < way.index(run)):
                found.append(Breakdown(_place(axis, gradient[number]), "gradient", gradients[gradient]))
            if run is not None:
                found.append(Breakdown(_place(axis, run[number]), "run", runs[run]))
    return list(dict.fromkeys(found))


def _place(axis: Axis, index: int) -> str:
    return f"{axis.name} {axis.long_label(index)}"


def _first(way: Sequence[tuple[int, ...]], names: Mapping[tuple[int, ...], CellClass]) -> tuple[int, ...] | None:
    return next((at for at in way if at in names and names[at].name not in ("stable", "not run")), None)
