"""What is said below the tables of a run: how exact it was, how it was solved, and what it cost."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from toolkit.sensitivity.analysis import Result
    from toolkit.solution import Solution

COARSE = 1e-3
"""Local error of a step, a part of the scene's size (or rad), above which a run says that its steps are coarse."""


def coarseness(solution: Solution) -> list[str]:
    """What the steps' length does, and a warning where one of them left the motion unresolved."""
    error = solution.local_error
    if error is None:
        return []
    lines = [f"The largest error that a step is estimated to make is {error:.1e} of the scene's size."]
    if error > COARSE:
        lines.append(
            f"Warning: steps are coarse for this motion (more than {COARSE:g}), so that peaks and vibrations may be wrong. Try a smaller "
            f'solver.step, or let the run choose: --set solver.local_error={COARSE / 10:g}, with solver.scheme = "arnold-bruels".'
        )
    return lines


def chosen_steps(result: Result) -> list[str]:
    """What steps a run has chosen, and whose derivatives its gradients are."""
    if (result.solution.options or result.solution.system.scene.solver).local_error is None:
        return []
    times = result.solution.whole_run
    lengths = times[1:] - times[:-1]
    lines = [f"Steps were chosen from {lengths.min():.2g} to {lengths.max():.2g}."]
    return lines + (
        ["Gradients are those of the motion by these steps, held as they are."] if any(result.gradients.values()) else []
    )


def remarks(result: Result) -> list[str]:
    """Remarks of the responses, drift of the joints, iterations, wall times."""
    from toolkit.responses.stress import KSStress
    from toolkit.validity.energy_balance import energy_balance

    solution = result.solution
    lines = [
        f"{name} {response.remark(solution)} {result.units[name]}."
        for name, response in solution.system.scene.responses.items()
        if isinstance(response, KSStress) and solution.run_times is None
    ]
    lines += [
        f"bodies.{body} follows the tangent at its nominal design in {', '.join(names)}: an error of second order in the change."
        for body, names in solution.system.scene.extrapolated().items()
    ]
    if solution.run_times is not None:
        lines.append(
            f"{solution.steps} steps, of which {len(solution.times)} states are kept: all exceed solver.memory. The joints are off by at "
            f"most {solution.drift:.1e} of the scene's size."
        )
    elif solution.steps:
        lines.append(
            f"{solution.steps} steps; joints off by at most {solution.drift:.1e} of the scene's size, "
            f"energy balance by {energy_balance(solution).relative_defect:.1e} of the largest energy or work."
        )
        lines += chosen_steps(result) + coarseness(solution)
        if solution.correction > solution.system.scene.solver.tolerance:
            lines.append(
                f"Newton was content with a correction of {solution.correction:.1e}: round-off kept it above solver.tolerance."
            )
    else:
        lines.append(f"Equilibrium under the loads at t = {solution.times[-1]:g}, reached in {solution.load_steps} load steps.")
        lines += [f"Warning: {beyond_limits(result)}"] if beyond_limits(result) else []
        left_out = [name for name in solution.system.scene.responses if name not in result.values]
        if left_out:
            lines.append(f"Left out, because they need a motion: {', '.join(left_out)}.")
    whole = solution.system.n_x > 0 and not result.gradients
    price = f"{solution.newton_iterations} Newton iterations, {1e3 * result.wall_primal:.1f} ms "
    price += "with everything kept" if whole else "without gradients"
    if result.gradients:
        price += f", {1e3 * result.wall_sensitivity:.1f} ms more for gradients (method {result.method})"
    return [*lines, f"{price}.", *([f"Gradients by {result.reason}"] if result.reason else [])]


def beyond_limits(result: Result) -> str:
    """In words: which limit points lie between the unloaded state and this one; empty if none."""
    path = result.solution.path
    if not path or not path.passed_limit:
        return ""
    passed = "; ".join(f"{each.percent} of the load, {each.coordinate} runs away" for each in path.limit_points)
    others = (
        f" It met {path.unstable_crossings} unstable equilibria under the full load before." if path.unstable_crossings else ""
    )
    return (
        f"this equilibrium lies BEYOND A SNAP-THROUGH. The path from the unloaded state turns back at limit points ({passed}); a real "
        f"structure jumps at the first, and may come to rest elsewhere.{others}"
    )
