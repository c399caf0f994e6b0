"""Errors of values and gradients by frozen reduced bases away from their design, by the same analysis with more shapes.

The shapes of a frozen basis are those of one design. Its file holds the body in so many more shapes that these can follow any design,
see `preprocessing.reduction.reduced`; with numbers f, and f' in more shapes,

    error of f  =  f - f'
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from toolkit.foundation.errors import ToolkitError
from toolkit.foundation.verdict import Caution
from toolkit.scene.scene import Scene
from toolkit.validity.bodies.deformation import LIMIT
from toolkit.validity.bodies.few_shapes import FrozenBody, frozen_bodies

FROZEN = "frozen-basis"
REMARK_ERROR = 0.02
"""Relative error by a frozen basis above which there is a remark; from `LIMIT` on it is a doubt."""
UNIMPORTANT = 0.02
"""Effect of a gradient on its response, relative to that of the most important gradient, below which it is left out without a motion."""
MEANINGLESS_ERROR = 1e3
"""Relative error of a number beyond which the number is taken for zero."""
UNIMPORTANT_CHANGE = 1e-3
"""Relative change of a value by a change of the variable by its size, below which the derivative is left out."""
MOST_NAMED = 6
"""Largest count of numbers that are named one by one."""

Slopes = Mapping[str, Mapping[str, float]]
Enriched = Callable[[], tuple[Mapping[str, float], Slopes]]
"""Values and gradients of the same analysis with more shapes in frozen bodies."""


class ComparedBases(NamedTuple):
    """One number of the run, the same number with more shapes, and the scale of their difference."""

    told: float
    true: float
    scale: float

    @property
    def part(self) -> float:
        """Signed error of the number, relative to its scale."""
        off = self.told - self.true
        return off / self.scale if self.scale > 0 else float(np.sign(off) * np.inf if off else 0.0)


@dataclass(frozen=True)
class BasisErrors:
    """Errors of one run by its frozen bases; `failure` says why there are none."""

    bodies: Sequence[FrozenBody]
    numbers: Mapping[str, ComparedBases] = field(
        default_factory=dict
    )  # what it is called -> of values, and of gradients that count
    failure: str = ""

    def record(self) -> dict[str, object]:
        """Errors, and the bodies that they come from, as part of a JSON object."""
        return {
            "bodies": {
                each.name: {"moved": {p: list(v) for p, v in each.moved.items()}, "asked": list(each.asked)}
                for each in self.bodies
            },
            "errors": {name: each.part for name, each in self.numbers.items()},
            **({"failure": self.failure} if self.failure else {}),
        }


def basis_errors(
    bodies: Sequence[FrozenBody],
    values: Mapping[str, tuple[float, float]],
    gradients: Mapping[str, Mapping[str, tuple[float, float]]],
    sizes: Mapping[str, float],
    enriched: Enriched,
) -> BasisErrors:
    """Errors of values and gradients by frozen bases, from the same analysis with more shapes.

    Parameters
    ----------
    values : response -> value, and what an error of it is compared with if that is larger than the true value
    gradients : response -> variable -> the same of the derivative
    sizes : variable -> its size
    """
    if not any(each.known for each in bodies):
        return BasisErrors(bodies)
    try:
        true, slopes = enriched()
    except ToolkitError as error:
        return BasisErrors(bodies, failure=str(error))
    found = {f: _compared(value, true[f], scale) for f, (value, scale) in values.items()}
    for f, row in gradients.items():
        most = max((abs(slopes[f][x]) * sizes[x] for x in row), default=0.0)
        felt = UNIMPORTANT_CHANGE * max(abs(true[f]), abs(values[f][0]))
        for x, (slope, scale) in row.items():
            counts = felt if scale > 0 else max(UNIMPORTANT * most, felt)  # a scale is a small effect of the variable at least
            if max(abs(slope - slopes[f][x]), abs(slope)) * sizes[x] > counts:
                found[derivative(f, x)] = _compared(slope, slopes[f][x], scale)
    return BasisErrors(bodies, {name: each for name, each in found.items() if np.isfinite([each.told, each.true]).all()})


def derivative(response: str, variable: str) -> str:
    """What a derivative is called among the numbers of a run."""
    return f"the derivative of {response} by {variable}"


def _compared(told: float, true: float, scale: float) -> ComparedBases:
    return ComparedBases(told, true, max(abs(true), scale))


def frequency_errors(
    scene: Scene, frequencies: Mapping[str, float], enriched: Callable[[], Mapping[str, float]]
) -> BasisErrors | None:
    """Errors of a list of frequencies by frozen bases, by their names; None where no frozen body is off its design."""
    bodies = frozen_bodies(scene)
    vibrating = {name: (value, 0.0) for name, value in frequencies.items() if value}
    return basis_errors(bodies, vibrating, {}, {}, lambda: (enriched(), {})) if bodies and vibrating else None


def cautions_of_frozen(found: BasisErrors | None) -> Iterator[Caution]:
    """Cautions about numbers that frozen bases make wrong, and about bodies whose errors are not known."""
    if found is None:
        return
    for body in found.bodies:
        if not body.known:
            yield _not_known(
                [body],
                f"{body.model} does not hold the body in more shapes. Build it again with ffrf-preprocess, {_remedy(body)}.",
            )
    known = [body for body in found.bodies if body.known]
    if found.failure:
        yield _not_known(known, f"the same analysis with more shapes fails. {found.failure}")
    off = {name: each for name, each in found.numbers.items() if abs(each.part) > REMARK_ERROR}
    if off:
        worst = sorted(off, key=lambda name: -abs(off[name].part))
        more = f" and {len(worst) - MOST_NAMED} more" if len(worst) > MOST_NAMED else ""
        yield Caution(
            FROZEN,
            f"{'; '.join(map(_state, known))}: {', '.join(_words(name, off[name]) for name in worst[:MOST_NAMED])}{more}. Found by "
            f"repeating the analysis with {', '.join(f'{b.shapes[1]} shapes of {b.name} instead of {b.shapes[0]}' for b in known)}. "
            f"Fix: build {', '.join(b.model for b in known)} {_remedy(known[0])}.",
            doubt=abs(off[worst[0]].part) > LIMIT,
        )


def _not_known(bodies: Sequence[FrozenBody], why: str) -> Caution:
    """A doubt that the errors of frozen bases are not known, without a number."""
    return Caution(FROZEN, f"{'; '.join(map(_state, bodies))}: by how much numbers are off is not known, as {why}")


def _words(name: str, each: ComparedBases) -> str:
    part = abs(each.part)
    size = f" by {part:.2g} times" if part >= 10 else f" by {part:.0%}" if part >= 0.1 else f" by {part:.1%}"
    return f"{name} is off{size if part < MEANINGLESS_ERROR else ''} ({each.told:.4g} instead of about {each.true:.4g})"


def _state(body: FrozenBody) -> str:
    """A phrase on what is wrong with the frozen basis of one body."""
    if not body.moved:
        return f"the shapes of {body.name} do not follow the design, as its basis is frozen"
    where = ", ".join(f"{parameter} = {here:g} instead of {own:g}" for parameter, (here, own) in body.moved.items())
    return f"the shapes of {body.name} are frozen at another design ({where})"


def _remedy(body: FrozenBody) -> str:
    if body.moved:
        return "with the values of this design, with more shapes ([basis] count), or with all (without [basis])"
    return 'with derivative = "differentiated" in [basis], with more shapes, or with all (without [basis])'
