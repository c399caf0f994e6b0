"""The tables of a report: as lists for JSON, as CSV files, and as they stand on the page."""

from __future__ import annotations

from typing import Any

import numpy as np

from toolkit.description.design import label
from toolkit.files.gradient_units import per, variable_unit
from toolkit.foundation.units import unit
from toolkit.report.answer import AnswerTable
from toolkit.report.material import ReportMaterial
from toolkit.responses.stress import KSStress, gap_bound, kreisselmeier_steinhauser

AGGREGATIONS = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)
"""Parameters of the table, beside the scene's own."""
_JUDGES = {
    "forward-difference": "The forward difference uses steps of 1e-6 of the value.",
    "central-difference": "The central difference uses steps of 1e-5 of the value.",
    "complex-step": "The complex step is exact to round-off.",
}
"""Sentences on the methods that gradients are compared with."""


def response_table(material: ReportMaterial) -> AnswerTable:
    """Values of all responses."""
    results = material.results
    rows = [[name, value, results.response_units[name]] for name, value in results.responses.items()]
    return AnswerTable(["response", "value", "unit"], rows, "responses", "Responses", "Value of every response of the scene.")


def variable_table(material: ReportMaterial) -> AnswerTable:
    """Design variables with their values."""
    rows = [
        [n, label(each), each["value"], variable_unit(material.scene, each["path"])]
        for n, each in material.results.variables.items()
    ]
    return AnswerTable(
        ["variable", "path", "value", "unit"], rows, "variables", "Design variables", "What the derivatives are by."
    )


def ks_tables(material: ReportMaterial) -> list[AnswerTable]:
    """Tables of the smooth maximum over its parameter, with the most it can exceed the true one, ln(n) / rho (paper, table 1)."""
    known = {name: response for name, response in material.scene.responses.items() if isinstance(response, KSStress)}
    return [_ks_table(material, name, response) for name, response in known.items()]


def _ks_table(material: ReportMaterial, name: str, response: KSStress) -> AnswerTable:
    stress, label = response.considered(material.solution), unit(material.scene.units, "stress")
    largest = float(stress.max())
    rows = []
    for rho in sorted({*AGGREGATIONS, response.aggregation}):
        sharpness = rho / (response.reference_stress or 1.0)
        value = float(kreisselmeier_steinhauser(stress, sharpness)[0].real)
        rows.append(
            [float(rho), value, value - largest, gap_bound(stress.size, sharpness), (value - largest) / abs(largest or 1.0)]
        )
    caption = (
        f"{name} against its aggregation parameter; the largest of the n = {stress.size} stresses is {largest:.8g} {label}. "
        f"The scene uses {response.aggregation:g}."
    )
    head = [
        "parameter" if response.reference_stress else f"rho in 1/{label}", f"KS in {label}", f"KS minus maximum in {label}",
        f"bound ln(n)/rho in {label}", "relative excess",
    ]  # fmt: skip
    return AnswerTable(head, rows, f"ks_{name}", "Smooth maximum and its parameter", caption)


def gradient_table(material: ReportMaterial) -> AnswerTable:
    """Gradients, and how far the other methods are from them (paper, table 2)."""
    results, rows = material.results, []
    for name, slopes in results.gradients.items():
        for variable, slope in slopes.items():
            label = per(results.response_units[name], variable_unit(material.scene, results.variables[variable]["path"]))
            others = [judge.gradients[name][variable] for judge in material.judges.values()]
            rows.append([name, variable, slope, label, *(abs(other - slope) / (abs(slope) or 1.0) for other in others)])
    compared = [f"relative difference to {method}" for method in material.judges]
    known = [words for method, words in _JUDGES.items() if method in material.judges]
    if any("difference" in method for method in material.judges):
        known.append("Where these steps hardly move a response, differences are round-off, and the last columns say nothing.")
    caption = " ".join(["Total derivatives of the responses.", *known])
    head = ["response", "variable", f"derivative ({results.method})", "unit", *compared]
    return AnswerTable(head, rows, "gradients", "Gradients", caption)


def cost_table(material: ReportMaterial) -> AnswerTable:
    """Wall times (paper, table 3)."""
    run, count = material.results.run, len(material.results.variables)
    primal = np.nan if run["wall_primal"] is None else run["wall_primal"]
    rows: list[list[Any]] = [["primal analysis", 1, primal, 1.0]]
    if material.results.method != "none":
        total = primal + (np.nan if run["wall_sensitivity"] is None else run["wall_sensitivity"])
        rows.append(
            [f"primal analysis and {material.results.method} differentiation", 1, total, total / primal if primal else np.nan]
        )
    for method, judge in material.judges.items():
        runs = count * (2 if method == "central-difference" else 1) + (method != "complex-step")
        total = (judge.wall_sensitivity or 0.0) + (judge.wall_primal or 0.0) * (method != "complex-step")
        rows.append([method, runs, total, total / primal if primal else np.nan])
    caption = (
        f"Wall times on the machine of this report, {count} variables. Compiled and warm; the median of several runs where a run is "
        f"short.{' The other methods compile the numbers of the scene anew for every run.' * bool(material.judges)}"
        f"{' The complex step runs as plain Python.' * ('complex-step' in material.judges)}"
    )
    return AnswerTable(["analysis", "runs", "wall time in s", "relative to primal"], rows, "cost", "Cost", caption)


def settings_table(material: ReportMaterial) -> AnswerTable:
    """Solver settings."""
    flat: dict[str, Any] = {}
    for key, value in material.results.settings.items():
        flat |= {f"{key}.{name}": item for name, item in value.items()} if isinstance(value, dict) else {key: value}
    rows = [[f"solver.{key}", "default" if value is None else value] for key, value in flat.items()]
    rows += [[f"changed: {key}", value] for key, value in material.results.scene.changes.items()]
    return AnswerTable(["setting", "value"], rows, "settings", "Settings", "Everything that the solver was told.")


def origin_table(material: ReportMaterial) -> AnswerTable:
    """Hashes of the files, versions of the programs."""
    results = material.results
    rows = [["scene file", results.scene.sha256 or "made in Python"]]
    rows += [[model, sha256] for model, sha256 in results.scene.models.items()]
    rows += [[f"version of {name}", version] for name, version in results.writers.items()]
    caption = "SHA-256 of the files that were read, versions of the programs."
    return AnswerTable(["file or program", "hash or version"], rows, "origin", "Files and versions", caption)


def monitor_table(material: ReportMaterial) -> list[AnswerTable]:
    """Energies and drift at every time."""
    if not material.moving:
        return []
    found, energy = material.monitors, unit(material.scene.units, "energy")
    energies = ("kinetic", "strain", "work", "defect")
    head = [f"time in {unit(material.scene.units, 'time')}", *(f"{name} in {energy}" for name in energies), "relative drift"]
    columns = (material.solution.times, *(getattr(found.energy, name) for name in energies), found.drift)
    return [AnswerTable(head, np.column_stack(columns).tolist(), "monitors", "Monitors", "Energies and drift over time.")]


def all_tables(material: ReportMaterial) -> list[AnswerTable]:
    """Every table that has something in it, in the order of the report."""
    tables = [
        response_table(material), variable_table(material), *ks_tables(material), gradient_table(material), cost_table(material),
        *monitor_table(material), settings_table(material), origin_table(material),
    ]  # fmt: skip
    return [table for table in tables if table.rows]
