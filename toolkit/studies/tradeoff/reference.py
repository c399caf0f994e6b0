"""What errors are measured against: ever finer runs of the second-order scheme, extrapolated, with an estimate of their own error.

Where the mesh of a skin is varied too, runs with ever finer meshes are extrapolated as well; the two corrections, and their errors, add
up. Where modes are varied, the reference keeps all coordinates; where frames are, it has one to every element.

Extrapolation is Richardson's. With runs f_1, f_2, f_3 at h, h/2, h/4 and an error of order p, the observed order and the extrapolated
values are

    p = log2 |(f_1 - f_2) / (f_2 - f_3)|,    e_k = f_(k+1) + (f_(k+1) - f_k) / (2^p - 1)
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

from toolkit.foundation.errors import ConvergenceError
from toolkit.scene.scene import Scene
from toolkit.studies.tradeoff.setting import ALL_SHAPES, EVERY_ELEMENT, Choice, ErrorQuantity, Setting, SettingOutcome

SCHEME_ORDER = 2
"""Of the scheme of the reference."""
REFERENCE_BUDGET_SHARE = 0.1
"""Part of a budget that the reference's own error may take."""
REFERENCE_SECONDS = 60.0
"""Largest time in s that a run of the reference is expected to take; the limit to its refinement."""
TOLERANCE = 1e-12
"""Of Newton's iteration, so that its error is none of the reference."""

REMARKED_ERROR = 1e-5
"""Relative error of a response below which it is not worth a remark."""

NEGLIGIBLE_SIZE = 1e-6
"""Part of the size of a response's gradient below which its value is no size to compare with, and the other way round."""
SIZE_OF_ZERO = 1e-300
"""Size where a response and its gradient are both zero."""

ORDER_TOLERANCE = 0.3
"""How far an observed order may be from the known one: the next power of h still counts where this one is seen."""
ORDERS = (0.8, 6.0)
"""Observed orders that can be believed where none is known."""
STALLED_ORDER = 0.5
"""Observed orders below, of either sign, are no convergence."""

Measure = Callable[[list[Setting]], list[SettingOutcome]]


@dataclass(frozen=True)
class ExtrapolatedLimit:
    """A value, how far off it may be, and the observed order; nan if the runs show none, so that nothing was extrapolated.

    `stalled`: the last halving changed as much as the one before, so that more of them may change it without end.
    """

    value: float
    error: float
    order: float
    stalled: bool = False

    def plus(self, other: ExtrapolatedLimit, at: float) -> ExtrapolatedLimit:
        """Both corrections of a value `at` at which both sequences meet; their errors add up."""
        return ExtrapolatedLimit(self.value + other.value - at, self.error + other.error, self.order, self.stalled)


def limit(runs: list[float], order: int | None) -> ExtrapolatedLimit:
    """Limit of the last three of runs, each with half the step of the one before.

    If the order is known and observed, the value is e_2 and its error |e_2 - e_1| / (2^(p+1) - 1): what the next power of h leaves.
    If it is only observed, the value is e_2 with that order, and its error as large as the whole correction |e_2 - f_3|. If none is
    observed (the runs do not converge yet, or have converged to round-off), the value is f_3 and its error the largest difference
    between the runs.
    """
    f_1, f_2, f_3 = runs[-3:]
    observed = _observed(f_1 - f_2, f_2 - f_3)
    if order is not None and abs(observed - order) <= ORDER_TOLERANCE:
        e_1, e_2 = (fine + (fine - coarse) / (2**order - 1) for coarse, fine in ((f_1, f_2), (f_2, f_3)))
        return ExtrapolatedLimit(e_2, abs(e_2 - e_1) / (2 ** (order + 1) - 1), observed)
    if order is None and ORDERS[0] <= observed <= ORDERS[1]:
        correction = (f_3 - f_2) / (2**observed - 1)
        return ExtrapolatedLimit(f_3 + correction, abs(correction), observed)
    return ExtrapolatedLimit(f_3, max(abs(f_3 - f_2), abs(f_2 - f_1)), math.nan, abs(observed) < STALLED_ORDER)


def _observed(before: float, after: float) -> float:
    return math.log2(before / after) if before * after > 0 else math.nan


@dataclass(frozen=True)
class Reference:
    """Limits of all responses and derivatives, and the runs they come from, in time and (where it is varied) in the mesh.

    `limits` has response -> Limit, `slopes` response -> variable -> Limit; `sizes` say what a relative change of a variable is.
    """

    limits: dict[str, ExtrapolatedLimit]
    slopes: dict[str, dict[str, ExtrapolatedLimit]]
    sizes: dict[str, float]
    units: dict[str, str]
    in_time: list[Setting]
    in_mesh: list[Setting]
    enough: bool

    def scale(self, quantity: ErrorQuantity) -> float:
        """What an error of a quantity is divided by, see `tradeoff`."""
        name, derived = quantity
        value = abs(self.limits[name].value)
        change = max((abs(each.value) * self.sizes[x] for x, each in self.slopes.get(name, {}).items()), default=0.0)
        own, other = (change, value) if derived else (value, change)
        return max(own, NEGLIGIBLE_SIZE * other, SIZE_OF_ZERO)

    def error(self, quantity: ErrorQuantity) -> float:
        """Estimated error of a response, or of its gradient, relative as in `tradeoff`."""
        name, derived = quantity
        if not derived:
            return self.limits[name].error / self.scale(quantity)
        worst = max((each.error * self.sizes[x] for x, each in self.slopes[name].items()), default=0.0)
        return worst / self.scale(quantity)

    def order(self, quantity: ErrorQuantity) -> float:
        """Observed order in time: of the derivative that matters most, for a gradient; nan if none was observed."""
        name, derived = quantity
        if not derived:
            return self.limits[name].order
        slopes = self.slopes[name]
        return slopes[max(slopes, key=lambda x: abs(slopes[x].value) * self.sizes[x])].order if slopes else math.nan


def find_reference(
    scene: Scene, axes: dict[str, list[Choice]], budget: dict[ErrorQuantity, float], measure: Measure
) -> Reference:
    """Refine in time until that error is `REFERENCE_BUDGET_SHARE` of every budget, or the next run would take longer than
    `REFERENCE_SECONDS`.

    Raises
    ------
    ConvergenceError
        A run of the reference failed.
    """
    meshes = _meshes(axes)
    finest = _whole(scene, min((float(choice.solver["step"]) for choice in axes.get("step", [])), default=math.inf))
    in_time = [_setting(scene, axes, finest / 2**k, meshes[-1:]) for k in range(3)]
    in_mesh = [_setting(scene, axes, finest, [n]) for n in meshes] if meshes else []
    outcomes = _measured(measure, [*in_time, *in_mesh[:-1]])
    times, others = outcomes[:3], outcomes[3:]
    while not _exact(_reference(times, [], in_time, []), budget) and 2 * times[-1].seconds < REFERENCE_SECONDS:
        finer = _setting(scene, axes, in_time[-1].solver["step"] / 2, meshes[-1:])
        try:
            times += _measured(measure, [finer])
        except ConvergenceError:  # so fine that round-off or memory end it: what there is has to do
            break
        in_time.append(finer)
    found = _reference(times, [*others, times[0]] if meshes else [], in_time, in_mesh)
    return replace(found, enough=_exact(found, budget))


def _exact(found: Reference, budget: dict[ErrorQuantity, float]) -> bool:
    return all(found.error(quantity) <= REFERENCE_BUDGET_SHARE * each for quantity, each in budget.items())


def _whole(scene: Scene, step: float) -> float:
    """The largest step that is not larger than this one or the scene's, and fits into the time as it is, so that halves do too."""
    end = scene.solver.end_time
    return end / math.ceil(end / min(step, scene.solver.step) * (1 - 1e-9))


def _meshes(axes: dict[str, list[Choice]]) -> list[int]:
    """Three meshes, each twice as fine, the last one twice as fine as the finest that is tried."""
    if "elements" not in axes:
        return []
    half = max(2, math.ceil(max(choice.skin["skin.elements"] for choice in axes["elements"]) / 2))
    return [half, 2 * half, 4 * half]


def _setting(scene: Scene, axes: dict[str, list[Choice]], step: float, mesh: list[int]) -> Setting:
    skin: dict[str, Any] = {"basis": {"kind": "full"}} if "modes" in axes else {}
    skin |= {"skin.elements": mesh[0]} if mesh else {}
    plain = ("formulation", "newton", "local_error", "times", *(["quasi_static"] if "quasi_static" in axes else []))
    solver: dict[str, Any] = dict.fromkeys(plain)
    solver |= {"scheme": "arnold-bruels", "tolerance": min(TOLERANCE, scene.solver.tolerance), "step": step}
    solver |= {"baumgarte": None} if "baumgarte" in axes else {}
    words = f"step {step:.6g}" + "".join(f", {n} elements" for n in mesh)
    frames, modes = (EVERY_ELEMENT if "frames" in axes else None), (ALL_SHAPES if "modes_per_frame" in axes else None)
    words += (", a frame to every element" if frames else "") + (", all shapes of its parts" if modes else "")
    return Setting({"reference": Choice(words, solver, skin, frames, modes)})


def _measured(measure: Measure, settings: list[Setting]) -> list[SettingOutcome]:
    outcomes = measure(settings)
    for setting, found in zip(settings, outcomes, strict=True):
        if found.failed:
            raise ConvergenceError(
                f"the reference ({setting.labels['reference']}) cannot be computed: {found.reason} Without it nothing can be "
                "measured; fix the scene, or begin at another step with --set solver.step."
            )
    return outcomes


def _reference(
    times: list[SettingOutcome], meshes: list[SettingOutcome], in_time: list[Setting], in_mesh: list[Setting]
) -> Reference:
    last = times[-1]

    def both(number: Callable[[SettingOutcome], float]) -> ExtrapolatedLimit:
        found = limit([number(each) for each in times], SCHEME_ORDER)
        if not meshes:
            return found
        return found.plus(limit([number(each) for each in meshes], None), number(meshes[-1]))

    limits = {name: both(lambda each, name=name: each.value(name)) for name in last.values}  # type: ignore[misc]
    slopes = {
        name: {x: both(lambda each, name=name, x=x: each.slope(name, x)) for x in of}  # type: ignore[misc]
        for name, of in last.gradients.items()
    }
    return Reference(limits, slopes, last.sizes, last.units, list(in_time), in_mesh, False)


def described(found: Reference) -> Iterator[str]:
    """What the reference is, and what it does not tell, in words."""
    steps = [setting.solver["step"] for setting in found.in_time[-3:]]
    yield (
        f"Errors are relative to a reference: scheme arnold-bruels with steps {', '.join(f'{step:.4g}' for step in steps)}, extrapolated."
    )
    if found.in_mesh:
        counts = [str(setting.skin["skin.elements"]) for setting in found.in_mesh]
        yield f"So are meshes of {', '.join(counts)} elements: errors contain that of the mesh."
    if found.in_time[-1].frames is not None:
        yield "Its bodies have one floating frame to every element: errors contain what fewer frames leave out."
    elif found.in_time[-1].modes is not None:
        yield "Its bodies keep all coordinates of their parts: errors contain what fewer shapes leave out."
    restless = [name for name, each in found.limits.items() if each.stalled and each.error > REMARKED_ERROR * abs(each.value)]
    if restless:
        yield (
            f"{', '.join(restless)}: every halving of the step changes it as much as the one before. It may depend on the number of time "
            "steps, as a smooth (KS) maximum over all of them does; errors are against the finest run."
        )
