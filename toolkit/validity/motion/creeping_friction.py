"""What the regularisation of friction did to a result: below its width it does not hold, but lets creep."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from toolkit.compilation.numbering import grips_of
from toolkit.compilation.quantities import named_loads
from toolkit.foundation.kernel import plain
from toolkit.foundation.near_ties import spread
from toolkit.foundation.units import unit
from toolkit.foundation.verdict import MOTION, REST, Caution, check
from toolkit.loads.friction import Friction
from toolkit.responses.marker_formula import MarkerMotion
from toolkit.system.solution import Solution
from toolkit.system.system import System, compile_scene

LOOKED_AT = 2000
"""Instants, evenly spread over the motion."""
STILL = 1e-9
"""Part of what the width itself would creep that is round-off of a scene at rest."""

MOST = 500
"""Unknowns of the largest scene whose frictions are asked for their rates, by dense matrices."""
ACCELERATIONS = np.array([1.0, 0.0, 0.0])
"""Weights of the constraints' accelerations, velocities and positions."""


@check("friction-width", (MOTION,))
def creeping_friction(solution: Solution) -> Iterator[Caution]:
    """What the width of a regularised friction is, for how long the motion was slower, and how far it crept meanwhile.

    Limit: any friction.
    Fix: a smaller width if the creep matters.
    """
    scene = solution.system.scene
    for k, (name, load) in enumerate(named_loads(scene).items()):
        if not isinstance(load, Friction):
            continue
        steps = np.array(spread(len(solution.times) - 1, LOOKED_AT))
        rates, times, width = np.abs(_rates(solution, name, k, steps)), solution.times[steps], float(np.real(load.width))
        slow = rates < width
        part = _integral(times, slow.astype(float)) / (times[-1] - times[0])
        label, crept = unit(scene.units, load.rate), _integral(times, np.where(slow, rates, 0))
        crept = crept if crept > STILL * width * (times[-1] - times[0]) else 0.0
        way = f"{crept:.3g} {label.partition('/')[0]}"
        said = f"Slower than that, {part:.0%} of the time, it lets creep: by {way}. {creeping_friction.fix}"
        yield creeping_friction.caution(
            f"loads.{name} is friction regularised by velocity, with a width of {width:g} {label}. "
            f"{said if np.any(slow) else 'Nothing was slower than that at any time.'}",
            doubt=False,
        )


@check("friction-at-rest", (REST,))
def friction_at_rest(solution: Solution) -> Iterator[Caution]:
    """Friction that is regularised by velocity holds nothing in an equilibrium.

    Limit: any friction.
    Fix: a motion that comes to rest.
    """
    for name, load in solution.system.scene.loads.items():
        if isinstance(load, Friction) and load.level:
            yield friction_at_rest.caution(
                f"loads.{name} is friction regularised by velocity, which holds nothing in an equilibrium. True friction would hold the "
                f"scene somewhere short of this one. Vibrations feel a damper of level / width. {friction_at_rest.fix}",
                doubt=False,
            )


def told_frictions(system: System, q: np.ndarray, step: float) -> str:
    """What to know of frictions whose width sets the step, in a position (n,); empty where steps resolve them all."""
    scene, found = system.scene, []
    frictions = {name: load for name, load in scene.loads.items() if isinstance(load, Friction) and np.real(load.width) > 0}
    if not frictions or system.n > MOST:
        return ""
    narrow = _damping(system, q)
    for name, load in frictions.items():
        width = float(np.real(load.width))
        without = compile_scene(scene.with_number(f"loads.{name}.width", width / STILL))
        fastest = np.abs(_eigenvalues(system, q, narrow - _damping(without, q))).max(initial=0.0)
        if fastest * step > 1:
            label = unit(scene.units, load.rate)
            found.append(
                f"Below its width of {width:g} {label} loads.{name} stops what moves in {1 / fastest:.2g} s, which steps of {step:g} do "
                f"not resolve: widen it to {width * fastest * step:.2g} {label}, or take steps of {1 / fastest:.1g}."
            )
    return " ".join(found)


def _damping(system: System, q: np.ndarray) -> np.ndarray:
    """Derivatives (n, n) of the forces by the velocities, at rest."""
    rest = np.zeros(system.n)
    return np.real(system.dense(system.evaluate(system.inputs(0.0, ACCELERATIONS), q, rest, rest).A_v))


def _eigenvalues(system: System, q: np.ndarray, damping: np.ndarray) -> np.ndarray:
    """Rates at which a damping matrix (n, n) stops the bodies, as their joints let them move; none where those are redundant."""
    rest = np.zeros(system.n)
    inertia = np.real(system.dense(system.evaluate(system.inputs(0.0, ACCELERATIONS), q, rest, rest).I_acc))
    try:
        return np.linalg.eigvals(np.linalg.solve(inertia, damping))
    except np.linalg.LinAlgError:
        return np.zeros(0)


def _rates(solution: Solution, name: str, k: int, steps: np.ndarray) -> np.ndarray:
    """g' at some steps, (n_steps,)."""
    system, load, found = solution.system, named_loads(solution.system.scene)[name], np.zeros(len(steps))
    motion, numbers = MarkerMotion.of(system, grips_of(f"loads.{name}", load)), np.real(system.plan.loads.parameter[k])
    assert isinstance(load, Friction)
    for n, step in enumerate(steps):
        a, b = motion.at(solution, int(step))
        w = np.real(np.concatenate([a.rate, b.rate]))
        slope, bend = np.zeros(len(w)), np.zeros((len(w), len(w)))
        plain(load.measured())(np.real(np.concatenate([a.y, b.y, numbers])), slope, bend)
        found[n] = slope @ w
    return found


def _integral(times: np.ndarray, values: np.ndarray) -> float:
    return float(np.sum(np.diff(times) * (values[1:] + values[:-1]) / 2))
