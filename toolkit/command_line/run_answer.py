"""The answer of a run: values and gradients of the responses, how far bodies deform, what the run cost, and whether to trust it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cached_property
from math import isnan
from typing import TYPE_CHECKING

from toolkit.foundation.units import unit
from toolkit.report.answer import Answer, AnswerTable, Record

if TYPE_CHECKING:
    from toolkit.analyses.sensitivity.run import Run
    from toolkit.system.solution import Solution
    from toolkit.validity.bodies.bent_surfaces import Measured

Deformations = Mapping[str, "Measured | None"]


class RunAnswer(Answer):
    """Motion or equilibrium of a scene."""

    result: Run

    @cached_property
    def deformations(self) -> Deformations:
        """Flexible body -> how far it deforms, beside the small deformations that the formulation assumes."""
        from toolkit.validity.bodies.bent_surfaces import geometric_errors

        return geometric_errors(self.result.solution)

    def record(self) -> Record:
        """JSON object."""
        from toolkit.files.gradient_units import gradient_units
        from toolkit.validity.start_cautions import start_record

        result, solution, bodies = self.result, self.result.solution, self.deformations
        return {
            "responses": {name: {"value": value, "unit": result.units[name]} for name, value in result.values.items()},
            "gradients": result.gradients,
            "gradient_units": gradient_units(solution.system.scene, result.gradients),
            **({"start": start_record(solution)} if solution.steps else {}),
            "run": {
                "method": result.method,
                "reason": result.reason,
                "steps": solution.load_steps or solution.steps,
                "newton_iterations": solution.newton_iterations,
                "wall_s": {"primal": result.wall_primal, "sensitivity": result.wall_sensitivity},
                **path_record(result),
            },
            **self.verdict.record(),
            **({"deformation": deformation_record(solution, bodies)} if bodies else {}),
        }

    def tables(self) -> Iterator[AnswerTable | str]:
        """Values, gradients and deformations, then how exact the run was, how it was solved, and what it cost."""
        from toolkit.files.tables import table_of_gradients, table_of_values

        for short in filter(None, (table_of_values(self.result), table_of_gradients(self.result))):
            yield AnswerTable(short.columns, short.rows)
        if self.deformations:
            yield deformation_table(self.result.solution, self.deformations)
        yield from remarks(self.result)


def path_record(result: Run) -> Record:
    """Record of what a static solution has passed on its path, if that was followed past limit points."""
    path = result.solution.path
    if not path or not path.passed_limit:
        return {}
    return {
        "beyond_snap_through": True,
        "limit_points": [{"load_factor": each.load_factor, "coordinate": each.coordinate} for each in path.limit_points],
        "unstable_equilibria_under_full_load": path.unstable_crossings,
    }


def deformation_record(solution: Solution, found: Deformations) -> Record:
    """Part of the JSON object about small deformations: None for a body of which no meter knows anything."""
    from toolkit.validity.bodies.deformation import LIMIT

    length = unit(solution.system.scene.units, "length")
    return {
        body: each
        and {
            "largest_rotation": {"value": each.rotation, "unit": "rad"},
            "largest_displacement": {"value": each.displacement, "unit": length},
            "geometric_error": {"value": each.error, "unit": length},
            "relative_to_displacement": each.relative,
            "relative_to_size": each.error / each.size,
            "limit": LIMIT,
            "time": each.time,
        }
        for body, each in found.items()
    }


def deformation_table(solution: Solution, found: Deformations) -> AnswerTable:
    """Table with one row per flexible body."""
    length, rows = unit(solution.system.scene.units, "length"), []
    for body, each in found.items():
        numbers = each and (each.rotation, each.displacement, each.error, each.relative, each.error / each.size)
        words = ["-" if isnan(number) else f"{number:.3g}" for number in numbers] if numbers else ["not available"] * 5
        rows.append((body, *words))
    sizes = ["largest rotation, rad", f"displacement, {length}", f"geometric error, {length}", "of displacement", "of size"]
    return AnswerTable(["deformation of", *sizes], rows)


def accuracy(result: Run) -> list[str]:
    """Sentences on the time-step error of values and gradients, as far as it is known."""
    lines, found = [], result.step_error
    if result.solution.local_error is not None:
        lines.append(f"Largest estimated local error of a step: {result.solution.local_error:.1e} of the model size.")
    if found is not None:
        slopes = [error for each in found.gradients.values() for error in each.values()]
        parts = [
            f"values {max(found.values.values(), default=0.0):.1e}",
            *([f"gradients {max(slopes):.1e}"] if slopes else []),
        ]
        lines.append(f"Estimated time-step error: {', '.join(parts)} of each response's peak (from a run {found.how}).")
    return lines


def _percent(part: float) -> str:
    """Part in percent, with two digits; zero where round-off makes it negative."""
    return f"{100 * part:.2g} %" if part > 0 else "0 %"


def chosen_steps(result: Run) -> list[str]:
    """Sentences on the steps that a run has chosen, and on whose derivatives its gradients are."""
    if (result.solution.options or result.solution.system.scene.solver).local_error is None:
        return []
    times = result.solution.whole_run
    lengths = times[1:] - times[:-1]
    lines = [f"Steps were chosen from {lengths.min():.2g} to {lengths.max():.2g}."]
    return lines + (
        ["Gradients are those of the motion by these steps, held as they are."] if any(result.gradients.values()) else []
    )


def remarks(result: Run) -> list[str]:
    """Sentences on responses, constraint violation and energy balance, iterations and wall times."""
    from toolkit.responses.stress import KSStress
    from toolkit.validity.start_cautions import start_lines

    solution = result.solution
    lines = [
        f"{name} {response.remark(solution)} {result.units[name]}."
        for name, response in solution.system.scene.responses.items()
        if isinstance(response, KSStress) and solution.run_times is None
    ]
    if solution.run_times is not None:
        lines.append(
            f"{solution.steps} steps, of which {len(solution.times)} states are kept: all exceed solver.memory. "
            f"Largest constraint violation: {solution.drift:.1e} of the model size."
        )
    elif solution.steps:
        balance = result.verdict.measures["energy_balance"]
        lines.append(
            f"{solution.steps} steps. Largest constraint violation: {solution.drift:.1e} of the model size. Energy balance: "
            f"{_percent(balance['created'])} gained, {_percent(balance['lost'])} lost, relative to the largest energy or work (after "
            "damping and quadrature error)."
        )
        lines += chosen_steps(result) + accuracy(result) + start_lines(solution)
    else:
        lines.append(f"Equilibrium under the loads at t = {solution.times[-1]:g}, reached in {solution.load_steps} load steps.")
        left_out = [name for name in solution.system.scene.responses if name not in result.values]
        if left_out:
            lines.append(f"Left out, because they need a motion: {', '.join(left_out)}.")
    whole = solution.system.n_x > 0 and not result.gradients
    price = f"{solution.newton_iterations} Newton iterations"
    if result.wall_primal is not None:
        price += f", {1e3 * result.wall_primal:.1f} ms {'with everything kept' if whole else 'without gradients'}"
    if result.gradients and result.wall_sensitivity is not None:
        price += f", {1e3 * result.wall_sensitivity:.1f} ms more for gradients (method {result.method})"
    return [*lines, f"{price}.", *([f"Gradients by {result.reason}"] if result.reason else [])]
