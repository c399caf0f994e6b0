"""The study: all maps of a scene run, compared and named."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

from toolkit.analyses.sensitivity.direct import typical_size
from toolkit.files.gradient_units import converted, number_factor, response_factor
from toolkit.foundation.errors import InputError, meant
from toolkit.foundation.units import UNIT_SYSTEMS
from toolkit.foundation.verdict import Caution, Verdict
from toolkit.scene.scene import Scene
from toolkit.studies.executor import Executor, Progress, run_jobs
from toolkit.studies.stability.cells import (
    CellClass,
    CellJob,
    CellOutcome,
    Limits,
    gradient_class,
    run_class,
    slope_difference,
    value_difference,
)
from toolkit.studies.stability.map_result import Cell, FineReference, MapResult, StabilityResult
from toolkit.studies.stability.maps import PHYSICS, Axis, Map, baumgarte_map, finest_first, refined, step_map, steps_needed
from toolkit.studies.store import RunFolder
from toolkit.validity.scene_cautions import cautions_of_scene

MAPS = ("step", "baumgarte", *PHYSICS, "units")


def unit_map(scene: Scene, directory: Path) -> Map:
    """Map of the scene in every unit system; converted reduced models are written to a folder.

    Raises
    ------
    InputError
        The scene starts in a results file, whose numbers are in units of their own.
    """
    if scene.start_file is not None:
        raise InputError("it starts in a results file (solver.start), whose numbers are in units of their own")
    units = (scene.units, *(name for name in UNIT_SYSTEMS if name != scene.units))
    axis = Axis("units", units, 0)
    scenes: dict[tuple[int, ...], Scene] = {
        (k,): scene if k == 0 else converted(scene, name, directory) for k, name in enumerate(units)
    }
    return Map("units", "unit system", (axis,), scenes, "own units")


def maps_of(scene: Scene, names: Sequence[str] | None, directory: Path, most_steps: int) -> tuple[list[Map], dict[str, str]]:
    """Maps that were asked for, by default all that the scene has; and name -> why it has none of the others.

    Raises
    ------
    InputError
        A name is unknown, or the scene has nothing that this map varies.
    """
    unknown = [name for name in names or () if name not in MAPS]
    if unknown:
        raise InputError(f"unknown map {unknown[0]!r}{meant(unknown[0], MAPS)}; available: {', '.join(MAPS)}.")
    builders: dict[str, Callable[[Scene], Map]] = {
        "step": lambda each: step_map(each, most_steps),
        "baumgarte": baumgarte_map,
        **PHYSICS,
        "units": lambda each: unit_map(each, directory),
    }
    found, missing = [], {}
    for name in MAPS if names is None else dict.fromkeys(names):
        try:
            found.append(builders[name](scene))
        except InputError as error:
            if names is not None:
                raise InputError(f"there is no map {name!r} of this scene: {error}. Leave it out.") from error
            missing[name] = str(error)
    return found, missing


MOST_STEPS = 10_000
"""Largest number of steps of a cell that is run, unless the scene itself needs more."""
REMEDY = "Run it again with --jobs 1 or a smaller --most-steps."
Key = tuple[str, tuple[int, ...]]
OWN: Key = ("the scene itself", ())
FINE, HALF = "its own with another step", " with half the step"
OWN_HALF: Key = (OWN[0] + HALF, ())
ROUND_OFF = 1e-6
"""Relative difference allowed between unit systems: Newton stops at 1e-10 of the model size, and forces magnify that."""
ENDS = {"failed": "fails", "refused": "is refused", "not run": "is not run"}
"""Class of the scene itself -> what it does, for those that give no number."""


def stability(
    scene: Scene,
    design: Sequence[str] = (),
    names: Sequence[str] | None = None,
    limits: Limits | None = None,
    most_steps: int | None = None,
    jobs: int = 1,
    progress: Progress | None = None,
    kept: Path | None = None,
) -> StabilityResult:
    """Map where a scene runs stably.

    Parameters
    ----------
    scene : Scene
    design : variables whose gradient is judged; without any the motion alone is
    names : maps, see `MAPS`; by default all that the scene has
    limits : where classes end; by default the joints may open as far as the scene's own `solver.drift_tolerance`
    most_steps : cells that need more steps are not run; by default `MOST_STEPS`, or as many as the scene needs as it stands
    jobs : processes
    progress : called with runs done and runs in all
    kept : folder of all runs, where they are found again after an interruption; None keeps nothing

    Raises
    ------
    InputError
        A map or variable is unknown, or the scene cannot be compiled.
    StudyError
        A process was killed.
    """
    limits, design = limits or Limits(drift=scene.solver.drift_tolerance), list(design)
    most_steps = max(MOST_STEPS, steps_needed(scene)) if most_steps is None else most_steps
    scene.design_variables(design)
    with TemporaryDirectory(prefix="ffrf-stability-") as folder:
        maps, missing = maps_of(scene, names, Path(folder), most_steps)
        wanted = _jobs(scene, design, maps, most_steps)
        found = _run(wanted, Executor(jobs), progress, kept)
    for each in maps:
        if each.judge == "own units":
            cells = {at: changed.units for at, changed in each.scenes.items() if (each.name, at) in found}
            found |= {(each.name, at): _in_own_units(found[each.name, at], scene, units) for at, units in cells.items()}
    reference = _reference(scene, found, limits)
    own = found.get(OWN) or CellOutcome(status="refused", reason=_too_long(scene, most_steps))
    itself = _cell(own, reference.outcome if reference else found.get(OWN_HALF), limits)
    mapped = [MapResult(m, {at: _judged(m, at, found, reference, limits, most_steps) for at in m.scenes}) for m in maps]
    verdict = _verdict(scene, design, limits, itself, reference, mapped, most_steps)
    return StabilityResult(scene, design, limits, itself, reference, mapped, missing, verdict)


def _jobs(scene: Scene, design: list[str], maps: Sequence[Map], most_steps: int) -> dict[Key, CellJob]:
    """All runs: the scene itself, ever finer or with half the step, every cell, and its half step where that judges."""
    wanted: dict[Key, tuple[Scene, int]] = {OWN: (scene, most_steps)}
    if any(each.judge == "reference" for each in maps):
        wanted |= {(FINE, (k,)): (each, most_steps) for k, each in enumerate(finest_first(scene))}
    else:
        wanted[OWN_HALF] = (refined(scene, 2), 2 * most_steps)
    for each in maps:
        for at, changed in each.scenes.items():
            wanted[each.name, at] = (changed, most_steps)
            if each.judge == "half step":
                wanted[each.name + HALF, at] = (refined(changed, 2), 2 * most_steps)
    return {
        key: CellJob(each, design, _sizes(scene, each, design), not key[0].endswith(HALF))
        for key, (each, most) in wanted.items()
        if steps_needed(each) <= most
    }


def _run(jobs: Mapping[Key, CellJob], executor: Executor, progress: Progress | None, kept: Path | None) -> dict[Key, CellOutcome]:
    """Outcomes of all jobs; equal ones run once."""
    keys = {at: job.key for at, job in jobs.items()}
    wanted = {keys[at]: job for at, job in jobs.items()}
    store = RunFolder(kept, CellOutcome)
    found = run_jobs(CellJob.run, wanted, store, executor, progress, remedy=REMEDY, compile_first=True)
    return {at: found[key] for at, key in keys.items()}


def _sizes(scene: Scene, changed: Scene, design: list[str]) -> dict[str, float] | None:
    """Sizes of the scene's variables in other units, so that slopes stay comparable where a variable is zero; None in its own."""
    if changed.units == scene.units:
        return None
    variables = scene.design_variables(design)
    return {v.name: typical_size(scene, v) * number_factor(scene, v.path, changed.units) for v in variables}


def _too_long(scene: Scene, most_steps: int) -> str:
    return f"{steps_needed(scene)} steps, more than {most_steps:g} (--most-steps)"


def _in_own_units(found: CellOutcome, scene: Scene, units: str) -> CellOutcome:
    """Responses and slopes of the scene in other units, in those of the scene."""
    by = {f: response_factor(scene, f, units) for f in found.values}
    slopes = {f: {x: slope / by[f] for x, slope in row.items()} for f, row in found.gradients.items()}
    values, undecided = ({f: value / by[f] for f, value in each.items()} for each in (found.values, found.undecided))
    return replace(found, values=values, gradients=slopes, undecided=undecided)


def _reference(scene: Scene, found: Mapping[Key, CellOutcome], limits: Limits) -> FineReference | None:
    """The two finest runs in good order; None where there are not two, or nothing to compare."""
    fine = [(each.solver.step, found.get((FINE, (k,)))) for k, each in enumerate(finest_first(scene))]
    good = [(step, each) for step, each in fine if each and run_class(each, None, limits).name == "stable" and each.values]
    if len(good) < 2:
        return None
    (step, best), (_, after) = good[:2]
    return FineReference(
        step, best, value_difference(after, best), slope_difference(after.gradients, best.gradients, best.undecided)
    )


def _judged(
    mapped: Map,
    at: tuple[int, ...],
    found: Mapping[Key, CellOutcome],
    reference: FineReference | None,
    limits: Limits,
    most_steps: int,
) -> Cell:
    """Classes of one cell of a map."""
    here = found.get((mapped.name, at))
    if here is None:
        skipped = CellClass("not run", _too_long(mapped.scenes[at], most_steps))
        return Cell(skipped, skipped)
    if mapped.judge == "own units":
        return _cell(here, found.get(OWN), replace(limits, accuracy=ROUND_OFF))
    if mapped.judge == "half step":
        return _cell(here, found.get((mapped.name + HALF, at)), limits)
    return _cell(here, reference.outcome if reference else None, limits)


def _cell(here: CellOutcome, reference: CellOutcome | None, limits: Limits) -> Cell:
    return Cell(run_class(here, reference, limits), gradient_class(here, reference, limits), here)


def _verdict(
    scene: Scene,
    design: Sequence[str],
    limits: Limits,
    own: Cell,
    reference: FineReference | None,
    maps: Sequence[MapResult],
    most_steps: int,
) -> Verdict:
    """Verdict on whether the classes of the cells can be trusted."""
    cautions = [*_of_the_scene_itself(own, design), *_of_the_reference(scene, design, limits, reference, maps)]
    if scene.responses and any(each.map.judge == "reference" for each in maps):
        cautions += _of_what_was_cut_off(scene, reference, most_steps)
    return Verdict.of([*cautions, *cautions_of_scene(scene)])


def _of_the_scene_itself(own: Cell, design: Sequence[str]) -> Iterator[Caution]:
    if own.run.name in ENDS:
        yield Caution("as-it-stands", f"the scene {ENDS[own.run.name]} as it stands: {own.run.reason}", doubt=False)
    if not design:
        text = "the scene declares no design variables, so no gradient is judged. Name some with --variables."
        yield Caution("no-gradient", text, doubt=False)


def _of_the_reference(
    scene: Scene, design: Sequence[str], limits: Limits, best: FineReference | None, maps: Sequence[MapResult]
) -> Iterator[Caution]:
    if not scene.responses:
        yield Caution("no-responses", "the scene has no responses, so a wrong motion that ends in good order is not seen.")
    elif not any(each.map.judge == "reference" for each in maps):
        return
    elif best is None:
        yield Caution("no-reference", "no two steps that were tried run in good order, so maps of the solver have no reference.")
    elif best.next_values > limits.accuracy or (design and best.next_slopes > limits.accuracy):
        yield Caution(
            "coarse-reference",
            f"the finest step, {best.step:.3g}, differs from the next by {100 * best.next_values:.3g} % in the responses and "
            f"{100 * best.next_slopes:.3g} % in the gradient, so `inaccurate` means little in maps of the solver: the motion may be "
            "chaotic, or needs a smaller solver.step.",
        )


def _of_what_was_cut_off(scene: Scene, best: FineReference | None, most_steps: int) -> Iterator[Caution]:
    """A caution about runs for the reference that were left out because they need too many steps.

    It is a doubt where the reference is no finer than the scene.
    """
    wanted = [each for each in finest_first(scene) if steps_needed(each) > most_steps]
    if wanted:
        known = f"so that the reference has the step {best.step:.3g}" if best else "so that there is no reference"
        yield Caution(
            "cut-reference",
            f"steps down to {wanted[0].solver.step:.3g} were wanted for the reference, but those up to {wanted[-1].solver.step:.3g} need "
            f"more than {most_steps:g} steps (--most-steps), {known}.",
            doubt=best is None or best.step >= scene.solver.step,
        )
