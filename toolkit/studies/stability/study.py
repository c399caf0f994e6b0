"""The study: all maps of a scene run, compared and named."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

from toolkit.scene.scene import Scene
from toolkit.scene_file.conversion import number_factor, response_factor
from toolkit.sensitivity.numerical import typical_size
from toolkit.studies.places.place import Progress
from toolkit.studies.stability.catalogue import maps_of
from toolkit.studies.stability.doubts import verdict_of
from toolkit.studies.stability.found import Cell, Mapped, Reference, Study
from toolkit.studies.stability.map import Map
from toolkit.studies.stability.measure import Measured, Run, slope_difference, value_difference
from toolkit.studies.stability.pool import Task, measured
from toolkit.studies.stability.solver_maps import finest_first, refined, steps_needed
from toolkit.studies.stability.verdict import Limits, Verdict, of_gradient, of_run

MOST_STEPS = 10_000
"""Cells that need more are not run, unless the scene itself does."""
Key = tuple[str, tuple[int, ...]]
OWN: Key = ("the scene itself", ())
FINE, HALF = "its own with another step", " with half the step"
OWN_HALF: Key = (OWN[0] + HALF, ())
ROUND_OFF = 1e-6
"""What may differ between unit systems: Newton stops 1e-10 of the scene's size away, and forces magnify that."""


def stability(
    scene: Scene,
    design: Sequence[str] = (),
    names: Sequence[str] | None = None,
    limits: Limits | None = None,
    most_steps: int | None = None,
    jobs: int = 1,
    progress: Progress | None = None,
    kept: Path | None = None,
) -> Study:
    """Map where a scene runs stably.

    Parameters
    ----------
    scene : Scene
    design : variables whose gradient is judged; without any the motion alone is
    names : maps, see `catalogue.MAPS`; by default all that the scene has
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
        tasks = _tasks(scene, design, maps, most_steps)
        found = dict(zip(tasks, measured(list(tasks.values()), jobs, progress, kept), strict=True))
    for each in maps:
        if each.judge == "own units":
            cells = {at: changed.units for at, changed in each.scenes.items() if (each.name, at) in found}
            found |= {(each.name, at): _in_own_units(found[each.name, at], scene, units) for at, units in cells.items()}
    reference = _reference(scene, found, limits)
    own = found.get(OWN) or Measured(Run("refused", _too_long(scene, most_steps)))
    itself = _cell(own, reference.measured if reference else found.get(OWN_HALF), limits)
    mapped = [Mapped(m, {at: _judged(m, at, found, reference, limits, most_steps) for at in m.scenes}) for m in maps]
    verdict = verdict_of(scene, design, limits, itself, reference, mapped, most_steps)
    return Study(scene, design, limits, itself, reference, mapped, missing, verdict)


def _tasks(scene: Scene, design: list[str], maps: Sequence[Map], most_steps: int) -> dict[Key, Task]:
    """Everything that has to run: the scene itself, ever finer or with half the step, every cell, and its half step where that judges."""
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
        key: Task(each, design, _sizes(scene, each, design), not key[0].endswith(HALF))
        for key, (each, most) in wanted.items()
        if steps_needed(each) <= most
    }


def _sizes(scene: Scene, changed: Scene, design: list[str]) -> dict[str, float] | None:
    """In other units the sizes of the scene's variables, so that slopes stay comparable where a variable is zero."""
    if changed.units == scene.units:
        return None
    variables = scene.design_variables(design)
    return {v.name: typical_size(scene, v) * number_factor(scene, v.path, changed.units) for v in variables}


def _too_long(scene: Scene, most_steps: int) -> str:
    return f"{steps_needed(scene)} steps, more than {most_steps:g} (--most-steps)"


def _in_own_units(found: Measured, scene: Scene, units: str) -> Measured:
    """Responses and slopes of the scene in other units, in those of the scene."""
    by = {f: response_factor(scene, f, units) for f in found.values}
    slopes = {f: {x: slope / by[f] for x, slope in row.items()} for f, row in found.slopes.items()}
    values, undecided = ({f: value / by[f] for f, value in each.items()} for each in (found.values, found.undecided))
    return replace(found, values=values, slopes=slopes, undecided=undecided)


def _reference(scene: Scene, found: Mapping[Key, Measured], limits: Limits) -> Reference | None:
    """The two finest runs in good order; None where there is none, or nothing to compare."""
    fine = [(each.solver.step, found.get((FINE, (k,)))) for k, each in enumerate(finest_first(scene))]
    good = [(step, each) for step, each in fine if each and of_run(each, None, limits).name == "stable" and each.values]
    if len(good) < 2:
        return None
    (step, best), (_, after) = good[:2]
    return Reference(step, best, value_difference(after, best), slope_difference(after.slopes, best.slopes, best.undecided))


def _judged(
    mapped: Map, at: tuple[int, ...], found: Mapping[Key, Measured], reference: Reference | None, limits: Limits, most_steps: int
) -> Cell:
    """Name of one cell of a map."""
    here = found.get((mapped.name, at))
    if here is None:
        skipped = Verdict("not run", _too_long(mapped.scenes[at], most_steps))
        return Cell(skipped, skipped)
    if mapped.judge == "own units":
        return _cell(here, found.get(OWN), replace(limits, accuracy=ROUND_OFF))
    if mapped.judge == "half step":
        return _cell(here, found.get((mapped.name + HALF, at)), limits)
    return _cell(here, reference.measured if reference else None, limits)


def _cell(here: Measured, reference: Measured | None, limits: Limits) -> Cell:
    return Cell(of_run(here, reference, limits), of_gradient(here, reference, limits), here)
