"""What a study of stability returns: cells with their classes, maps, the reference, and all of it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import groupby
from typing import TYPE_CHECKING, Literal, NamedTuple

from toolkit.foundation.verdict import Verdict
from toolkit.scene.scene import Scene
from toolkit.studies.stability.cells import CellClass, CellOutcome, Limits
from toolkit.studies.stability.maps import Axis, Map

if TYPE_CHECKING:
    from toolkit.foundation.value_types import Record


@dataclass(frozen=True)
class Cell:
    """What one cell of a map gave, and what it is called; without variables the gradient has no name."""

    run: CellClass
    gradient: CellClass | None
    outcome: CellOutcome | None = None


@dataclass(frozen=True)
class MapResult:
    """A map with its cells by the number of the value on each axis."""

    map: Map
    cells: Mapping[tuple[int, ...], Cell]


@dataclass(frozen=True)
class FineReference:
    """The scene's own motion with the finest step that ran in good order, and how far the next coarser one is from it."""

    step: float
    outcome: CellOutcome
    next_values: float
    next_slopes: float


@dataclass(frozen=True)
class StabilityResult:
    """All maps of a scene; `missing` says why it has none of some kind, `own` what it is as it stands, `verdict` whether to believe it."""

    scene: Scene
    design: list[str]
    limits: Limits
    own: Cell
    reference: FineReference | None
    maps: list[MapResult]
    missing: dict[str, str]
    verdict: Verdict


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


def record_of(study: StabilityResult) -> Record:
    """Everything that was found; numbers that do not exist are nan, in JSON null."""
    best = study.reference
    return {
        "criteria": asdict(study.limits),
        "variables": study.design,
        "as_it_stands": _cell(study.own),
        "reference": None if best is None else {
            "step": best.step, "next_step_differs_by": {"responses": best.next_values, "gradients": best.next_slopes},
        },
        "maps": {each.map.name: _map(each) for each in study.maps},
        "without_map": study.missing,
        **study.verdict.record(),
    }  # fmt: skip


def criteria(limits: Limits) -> list[str]:
    """When a cell is called stable."""
    return [
        f"Stable: the run ends, joints open by at most {limits.drift:g} of the model size, at most {100 * limits.energy:g} % of the "
        f"energy is created, and responses are within {100 * limits.accuracy:g} % of the reference (solver maps: the finest step of the "
        "scene; other maps: half the step).",
        f"Stable gradient: the run is not drifting, direct differentiation and adjoint agree to {limits.agreement:g}, and the gradient is "
        f"within {100 * limits.accuracy:g} % of that of the reference.",
    ]


def _map(each: MapResult) -> Record:
    return {
        "title": each.map.title,
        "compared_with": each.map.judge,
        "axes": [_axis(axis) for axis in each.map.axes],
        "mapped": mapped_range(each),
        "stable": {"run": stable_where(each, "run"), "gradient": stable_where(each, "gradient")},
        "beyond": [{"at": b.place, "of": b.of, **_class(b.verdict)} for b in breakdowns(each)],
        "cells": [{"at": list(at), **_cell(cell)} for at, cell in each.cells.items()],
    }


def _axis(axis: Axis) -> Record:
    return {**vars(axis), "values": list(axis.values)}


def _cell(cell: Cell) -> Record:
    gradient = None if cell.gradient is None else _class(cell.gradient)
    return {"run": _class(cell.run), "gradient": gradient, **({} if cell.outcome is None else _outcome(cell.outcome))}


def _class(found: CellClass) -> dict[str, str]:
    return {"class": found.name, "reason": found.reason}


def _outcome(found: CellOutcome) -> Record:
    return {
        "drift": found.drift,
        "energy_created": found.created,
        "methods_differ_by": found.disagreement,
        "seconds": found.seconds,
        "steps": found.steps,
        "newton_iterations": found.newton_iterations,
        "values": dict(found.values),
    }
