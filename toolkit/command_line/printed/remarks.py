"""What is said below the tables of a run: how exact it was, how it was solved, and what it cost."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from toolkit.sensitivity.run import Run


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
    from toolkit.responses.stress.stress import KSStress
    from toolkit.validity.start.start_state import start_lines

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
