"""A study as one JSON object, and its criteria in words."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from toolkit.studies.stability.cell_outcome import CellOutcome
from toolkit.studies.stability.classifier import CellClass, Limits
from toolkit.studies.stability.map import Axis
from toolkit.studies.stability.map_limits import breakdowns, mapped_range, stable_where
from toolkit.studies.stability.map_result import Cell, MapResult, StabilityResult


def record_of(study: StabilityResult) -> dict[str, Any]:
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


def _map(each: MapResult) -> dict[str, Any]:
    return {
        "title": each.map.title,
        "compared_with": each.map.judge,
        "axes": [_axis(axis) for axis in each.map.axes],
        "mapped": mapped_range(each),
        "stable": {"run": stable_where(each, "run"), "gradient": stable_where(each, "gradient")},
        "beyond": [{"at": b.place, "of": b.of, **_class(b.verdict)} for b in breakdowns(each)],
        "cells": [{"at": list(at), **_cell(cell)} for at, cell in each.cells.items()],
    }


def _axis(axis: Axis) -> dict[str, Any]:
    return {**vars(axis), "values": list(axis.values)}


def _cell(cell: Cell) -> dict[str, Any]:
    gradient = None if cell.gradient is None else _class(cell.gradient)
    return {"run": _class(cell.run), "gradient": gradient, **({} if cell.outcome is None else _outcome(cell.outcome))}


def _class(found: CellClass) -> dict[str, str]:
    return {"class": found.name, "reason": found.reason}


def _outcome(found: CellOutcome) -> dict[str, Any]:
    return {
        "drift": found.drift,
        "energy_created": found.created,
        "methods_differ_by": found.disagreement,
        "seconds": found.seconds,
        "steps": found.steps,
        "newton_iterations": found.newton_iterations,
        "values": dict(found.values),
    }
