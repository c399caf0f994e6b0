"""One analysis of a compiled scene, whatever gradients and start are asked for."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import NoReturn

from toolkit.analyses.run_start import known_start
from toolkit.analyses.statics import solve_statics
from toolkit.analyses.transient import simulate
from toolkit.foundation.compiled.compile_watch import watched_compilation
from toolkit.foundation.errors import InputError
from toolkit.foundation.processes import one_thread
from toolkit.sensitivity.compiled import Compiled
from toolkit.sensitivity.direct import again, by_direct, enriched, evaluated, values_alone, with_values
from toolkit.sensitivity.methods import by_method, more_frames
from toolkit.sensitivity.preparation import ANALYSES, METHODS, Kind, Progress, price, solve
from toolkit.sensitivity.run import Run
from toolkit.solvers.start.initial_conditions import continued_start
from toolkit.solvers.start.kept_start import refuse_other_run
from toolkit.system.model_files import refuse_changed


@one_thread()
def analysed(
    compiled: Compiled,
    kind: Kind,
    gradients: bool | str = False,
    start: Run | None = None,
    progress: Progress | None = None,
    timed: bool = False,
    keep_states: bool = False,
) -> Run:
    """Run of a compiled scene; arguments as of `Model.run`.

    Raises
    ------
    InputError
        There is no such method, or nothing to differentiate by; and all that the analysis raises.
    """
    check_method(gradients)
    if gradients and not compiled.names:
        raise InputError("gradients of what? The model has no design variables. Name some: compile(scene, variables=[...]).")
    refuse_changed(compiled.files)
    compiled = compiled.analysed_by(kind, more_frames if gradients else None)
    if start is not None:
        if timed:
            raise InputError("the price of a run with a start is not measured. Leave out one of timed and start.")
        return _from_start(compiled, kind, gradients, start, progress)
    if gradients:
        return by_method("auto" if gradients is True else str(gradients), compiled, kind, progress, keep_states, timed)
    with watched_compilation() as watch:
        solution = ANALYSES[kind](compiled.primal, progress=progress)
    return with_values(compiled, kind, solution, price(watch, timed, partial(solve, compiled.primal, kind)))


def check_method(gradients: bool | str) -> None:
    """Refuse a method for gradients that does not exist.

    Raises
    ------
    InputError
        It is neither a truth value nor a name of a method.
    """
    if not isinstance(gradients, bool) and not (isinstance(gradients, str) and gradients in METHODS):
        raise InputError(f"there is no method {gradients!r} for gradients. Write True, False, or one of: {', '.join(METHODS)}.")


def _from_start(compiled: Compiled, kind: Kind, gradients: bool | str, start: Run, progress: Progress | None) -> Run:
    """Run that begins in the last state of another one."""
    if gradients not in (False, True, "direct"):
        raise InputError(
            f"gradients of a run with a start are found by direct differentiation, not {gradients!r}. Write gradients=True."
        )
    if not isinstance(start, Run):
        raise InputError(f"start must be a run that an analysis has returned, not {type(start).__name__}.")
    system, known = (compiled.full if gradients else compiled.primal), start.solution
    if known.system.numbering.names != system.numbering.names:
        raise InputError("start is a run of a scene with other bodies or joints. Give one of the same scene, at any numbers.")
    refuse_other_run(system, known.system)
    if kind == "static":
        found = evaluated(solve_statics(system, progress=progress, start=known), bool(gradients))
        method = by_direct if gradients else values_alone
        return replace(found, enriched=partial(enriched, compiled, kind, found.solution, method))
    options = compiled.scene.solver.model_copy(update={"start": "given"})
    q, v, moved = continued_start(system, known.q[-1], known.v[-1], options)
    motion = simulate(system, options, q=q, v=v, progress=progress)
    repeat = partial(again, system, q=q, v=v, known=known_start(motion))
    solution = replace(motion, start_moved=moved)
    return replace(evaluated(solution, bool(gradients), repeat), enriched=_not_in_more_shapes)


def _not_in_more_shapes() -> NoReturn:
    """Refuse to begin with a richer basis where a run with a frozen basis has ended."""
    raise InputError(
        "The motion begins in the last state of a run with the shapes of the frozen basis, which tells no more of them."
    )
