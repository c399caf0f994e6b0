"""The certificate of a scene's gradients: independent methods compared, as far as round-off allows."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from toolkit.analyses.sensitivity.adjoint import adjoint_gradients, has_adjoint
from toolkit.analyses.sensitivity.certificate.differences import (
    NEGLIGIBLE_DERIVATIVE,
    SETTLED_DIFFERENCE,
    UNIMPORTANT_EFFECT,
    Gradients,
    Quotient,
    best_quotients,
    curve_of,
    difference_quotients,
    direction,
    jumping,
    round_off,
    slopes_along,
    taylor_rates,
)
from toolkit.analyses.sensitivity.direct import direct, numerical
from toolkit.analyses.sensitivity.preparation import Kind, Progress, by_name, frozen, response_scales, variable_sizes
from toolkit.analyses.sensitivity.run import Run
from toolkit.foundation.errors import InputError, ToolkitError
from toolkit.foundation.verdict import Caution, Verdict
from toolkit.scene.resolution import loaded
from toolkit.scene.scene import Scene

MOST_DIGITS = 16.0
TINY = float(np.finfo(float).tiny)


QUOTIENT_TOLERANCE, UNCERTAINTIES_ALLOWED = 1e-5, 10.0
"""Largest relative difference, by truncation, between a derivative along a direction and a difference quotient whose neighbours
agree; and the largest such difference in multiples of the quotient's uncertainty."""


class DisagreementError(ToolkitError, ArithmeticError):
    """Two methods that are exact give different gradients: one of them is wrong."""


class NothingVerifiedError(ToolkitError, ArithmeticError):
    """Round-off leaves no digits to compare, so that no gradient was verified."""


@dataclass(frozen=True)
class Certificate:
    """Comparison of a scene's gradients by independent methods.

    Attributes
    ----------
    exact : Run
        Run with gradients by direct differentiation.
    differences : dict
        "adjoint" (where the run has one) and "complex-step" -> response -> variable -> relative difference to `exact`.
    limits : dict
        Response -> variable -> relative difference up to which round-off explains it, see `round_off`: a derivative whose effect is a
        billionth of others' has fewer digits than they, whatever computes it.
    rates : dict
        Response -> rate at which Taylor's remainder vanishes; 2 if the gradient is right and the response smooth, infinite if the
        response is linear.
    curve : list of pairs
        Relative step of central differences along one direction, and their largest relative difference to `exact`.
    along : dict
        Response -> its derivative along that direction by `exact`.
    quotients : dict
        Response -> this derivative by the best central difference, with its uncertainty; it shares no formula of derivatives with
        the others.
    parts : dict
        Variable -> its part of that direction.
    jumping : tuple of str
        Responses whose differences are right with some step and wrong with a larger one that is still small.
    zeros : dict
        Response -> variable -> largest difference between the methods of a derivative that is negligible or that round-off does not tell
        from zero, and so has no digits of its own: in parts of the derivative by which a change of the variable by its size would change
        the response by all that it is or does (a place or an angle by the model size or 1 rad).
    """

    exact: Run
    differences: dict[str, Gradients]
    limits: Gradients
    rates: dict[str, float]
    curve: list[tuple[float, float]]
    along: dict[str, float] = field(default_factory=dict)
    quotients: dict[str, Quotient] = field(default_factory=dict)
    parts: dict[str, float] = field(default_factory=dict)
    jumping: tuple[str, ...] = ()
    zeros: Gradients = field(default_factory=dict)

    @property
    def verdict(self) -> Verdict:
        """Verdict of the run, with a doubt where differences along the direction do not settle on the derivative.

        The differences are taken with steps that shrink.
        """
        unknown = [
            f
            for f, each in self.quotients.items()
            if each.uncertainty > SETTLED_DIFFERENCE * abs(self.along[f]) > self._blurred(f)
        ]
        lost = dict.fromkeys([*unknown, *self.jumping])
        text = (
            f"central differences along one direction do not settle on the derivative of {', '.join(lost)} as their "
            "steps shrink from a thousandth of the variables on: the response jumps nearby (a spring through length zero, an event between "
            "two times), or is far from linear. The methods that agree share their formulas; look at the response over "
            "these variables."
        )
        found = self.exact.verdict
        return Verdict.of([*found.warnings, *([Caution("differences", text)] if lost else [])], found.measures)

    def verified(self, tolerance: float) -> int:
        """Number of derivatives on which all methods agree to the tolerance."""
        return sum(
            all(found[f][x] <= tolerance for found in self.differences.values())
            for f, limits in self.limits.items()
            for x in limits
        )

    def vanish(self, tolerance: float) -> bool:
        """Whether all derivatives are zero by all methods to the tolerance, as at an optimum between all bounds."""
        return all(self.zeros.get(f, {}).get(x, np.inf) <= tolerance for f, limits in self.limits.items() for x in limits)

    def check(self, tolerance: float) -> None:
        """Refuse gradients on which the exact methods disagree by more than the tolerance, and by more than round-off explains.

        Raises
        ------
        DisagreementError
            Names method, response and variable.
        NothingVerifiedError
            Round-off explains every difference, so that nothing is known.
        """
        for method, found in self.differences.items():
            for response, slopes in found.items():
                for variable, difference in slopes.items():
                    if not difference <= max(tolerance, self.limits[response][variable]):
                        raise DisagreementError(
                            f"direct differentiation and {method} disagree on d {response} / d {variable}: relative difference "
                            f"{difference:.1e}, more than {tolerance:.1e} and than round-off explains "
                            f"({self.limits[response][variable]:.1e}). Tighten solver.tolerance; if that does not help, one of them is "
                            "wrong: check components of your own with toolkit.api, and report what remains."
                        )
        self._check_quotients()
        if not self.verified(tolerance) and not self.vanish(tolerance):
            raise NothingVerifiedError(
                f"no gradient was verified: not one of them agrees to {tolerance:.1e} in all methods, and round-off may explain "
                "it, so that nothing is known of any. Motions that part for ever (behind a snap-through, or with steps that do not "
                "resolve it) leave no digits: try smaller steps, a shorter time, or other variables."
            )

    def _check_quotients(self) -> None:
        """Refuse gradients whose derivative along the direction differs from that of the best difference quotient."""
        for f, quotient in self.quotients.items():
            off = abs(self.along[f] - quotient.slope)
            if not off <= QUOTIENT_TOLERANCE * abs(self.along[f]) + UNCERTAINTIES_ALLOWED * quotient.uncertainty + self._blurred(
                f
            ):
                raise DisagreementError(
                    f"the gradient of {f} is contradicted by central differences: along one direction through all variables its "
                    f"derivative is {self.along[f]:.10g}, and {quotient.slope:.10g} by the best quotient, which is uncertain by "
                    f"{quotient.uncertainty:.1e}. The methods that agree share the formulas of derivatives: check components of your "
                    "own with toolkit.api, build reduced models again, and report what remains. A response with a kink at "
                    "this design (a maximum) has no derivative."
                )

    def _blurred(self, response: str) -> float:
        """Largest error that round-off of the derivatives themselves may add up to along the direction."""
        return sum(
            limit * abs(self.exact.gradients[response][x] * self.parts.get(x, 0.0)) for x, limit in self.limits[response].items()
        )


def certify(
    scene: Scene, design: list[str], kind: Kind, progress: Progress = lambda *_: None, unseen: float = UNIMPORTANT_EFFECT
) -> Certificate:
    """Compare direct differentiation with the adjoint, a complex step, Taylor's remainder and central differences.

    A derivative counts as zero where a change of its variable by its own size would change the response by less than the part `unseen` of
    what that is or does.

    Raises
    ------
    InputError
        As `direct`.
    """
    exact = direct(scene, design, kind)
    if not exact.gradients or not design:
        raise InputError("there is nothing to compare: the scene needs a table [responses] and a design variable.")
    progress(1, 5)
    stepped = numerical(scene, design, kind, "complex-step").gradients
    progress(2, 5)
    return compare(exact, kind, stepped, lambda done, total: progress(2 + done, 2 + total), unseen)


def compare(
    exact: Run, kind: Kind, stepped: Gradients, progress: Progress = lambda *_: None, unseen: float = UNIMPORTANT_EFFECT
) -> Certificate:
    """The certificate of a result of direct differentiation, whose gradients by a complex step are at hand."""
    system = exact.solution.system
    scene, design = system.scene, list(system.design.names)
    others = {"complex-step": stepped}
    if has_adjoint(scene, kind):
        found, gradient = adjoint_gradients(system, exact.solution)
        others = {"adjoint": by_name(system.design, found, gradient.T), **others}
    progress(1, 4)
    floors = round_off(scene, exact, kind, unseen)
    limits = {
        f: {x: min(1.0, floors[f][x] / max(abs(slope), TINY)) for x, slope in s.items()} for f, s in exact.gradients.items()
    }
    progress(2, 4)
    rates = taylor_rates(scene, design, kind, exact=exact)
    progress(3, 4)
    quotients = difference_quotients(scene, design, kind, exact)
    parts = direction(frozen(scene, exact.solution), exact)
    progress(4, 4)
    along = slopes_along(exact, parts)
    return Certificate(
        exact,
        {m: _relative(exact, floors, other) for m, other in others.items()},
        limits,
        rates,
        curve_of(scene, exact, quotients),
        along,
        best_quotients(quotients),
        parts,
        jumping(quotients, along, response_scales(exact, variable_sizes(scene, exact))),
        _zeros(scene, exact, limits, others),
    )


def digits(difference: float) -> float:
    """Number of decimal digits that agree, 0 to 16; nan where there was nothing to compare."""
    return (
        float(np.clip(-np.log10(difference), 0.0, MOST_DIGITS) + 0.0)
        if difference > 0
        else (MOST_DIGITS if difference == 0 else np.nan)
    )


def _relative(exact: Run, floors: Gradients, other: Gradients) -> Gradients:
    """Differences to other derivatives relative to each derivative, or to its floor where it is smaller."""
    return {
        f: {x: abs(slope - other[f][x]) / max(abs(slope), floors[f][x], TINY) for x, slope in slopes.items()}
        for f, slopes in exact.gradients.items()
    }


def _zeros(scene: Scene, exact: Run, limits: Gradients, others: dict[str, Gradients]) -> Gradients:
    """Largest differences between the methods for derivatives that are next to zero, relative to what a zero is measured by."""
    sizes, whole = variable_sizes(scene, exact), {"angle": 1.0, "length": loaded(scene).size}
    found: Gradients = {}
    for f, scale in response_scales(exact, sizes).items():
        unit = max(scale, whole.get(getattr(scene.responses.get(f), "unit_quantity", ""), 0.0), TINY)
        found[f] = {
            x: max(abs(slope - other[f][x]) for other in others.values()) * sizes[x] / unit
            for x, slope in exact.gradients[f].items()
            if limits[f][x] >= 1.0 or abs(slope) * sizes[x] <= NEGLIGIBLE_DERIVATIVE * unit
        }
    return found
