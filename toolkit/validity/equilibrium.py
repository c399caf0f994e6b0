"""Cautions about an equilibrium: which limit points lie before it, why it buckles, and whether a motion that stays in it would leave it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from toolkit.foundation.errors import BifurcationError
from toolkit.foundation.verdict import REST, SPIN, Caution, check
from toolkit.responses.flutter import REMEDY, UNSTABLE, growth_of, may_grow
from toolkit.responses.pencil import pencil_of, real_pencil
from toolkit.system.solution import Solution
from toolkit.validity.bodies.carried_force import turning_frames
from toolkit.validity.bodies.critical_load import compression
from toolkit.validity.bodies.deformation import LIMIT, divided
from toolkit.validity.frame_choice import advice_of_frame

LARGEST_MOVE, SHOWN_PART = 0.1, 0.05
"""How far a motion may go, in parts of the model size or rad, so that its end tells its stability; and which part of that it goes along
what grows, so that it shows it."""
MOTION_ROUND_OFF = 1e-9
"""Part of the model size or rad below which a motion is round-off."""
DOUBTED_GROWTH = 100.0
"""Growth over the motion from which on it is no answer to stay: whatever disturbs a real one is so many times as large at its end."""
FEIGNED_DEFLECTION = 1.0
"""Part by which deflections are feigned at nine tenths of a bifurcation, from which the frame is its reason: it would be nine."""
LASTING_LOAD_CHANGE = 0.05
"""Part of a load by which it may change while it lasts."""


@check("own-start", (REST, SPIN))
def found_from_another(solution: Solution) -> Iterator[Caution]:
    """An equilibrium was found from that of another design; the path from the unloaded state was not followed.

    Limit: any warm start.
    Fix: a run of its own.
    """
    if solution.own_start:
        yield found_from_another.caution(
            "the equilibrium was found from that of another design. Whether the path from the unloaded state leads to it was not followed. "
            f"{found_from_another.fix}",
            doubt=False,
        )


@check("snap-through", (REST, SPIN))
def limits_passed(solution: Solution) -> Iterator[Caution]:
    """The path from the unloaded state turns back at limit points before this equilibrium: a real structure jumps there.

    Limit: any limit point.
    Fix: a motion through the jump, or a smaller load.
    """
    path = solution.path
    if path is None or not path.passed_limit:
        return
    passed = "; ".join(f"{each.percent} of the load, {each.coordinate} runs away" for each in path.limit_points)
    others = (
        f" It met {path.unstable_crossings} unstable equilibria under the full load before." if path.unstable_crossings else ""
    )
    yield limits_passed.caution(
        f"this equilibrium lies BEYOND A SNAP-THROUGH. The path from the unloaded state turns back at limit points ({passed}). A real "
        f"structure jumps at the first, and may come to rest elsewhere.{others} {limits_passed.fix}",
    )


def bifurcation_of_frame(solution: Solution, error: BifurcationError) -> BifurcationError:
    """The error of a path that buckles, or one that says so if that is the false softness of a body under tension.

    Parameters
    ----------
    solution
        The equilibrium under most of the load before the bifurcation, where a frame that turns with one end of its body takes away most
        of the stiffness across the tension.
    """
    body = _softened_by_its_frame(solution)
    if not body:
        return error
    scene, factor = solution.system.scene, error.load_factor
    return BifurcationError(
        f"{body} is in tension and does not buckle, but its equations do, at {100 * factor:.6g} % of the load, in a motion of "
        f"{error.coordinate}: its frame turns with one end, and forces along the body turn with this frame, which takes stiffness from it. "
        f"Fix: {divided(scene, body, 1 / (factor * LIMIT))}.{advice_of_frame(scene, body)}",
        factor,
        error.coordinate,
    )


def _softened_by_its_frame(solution: Solution) -> str:
    """The body whose frame is the reason why an equilibrium is soft; empty without any."""
    found = compression(solution)
    if found is not None and found.feigned > max(FEIGNED_DEFLECTION, found.missed):
        return getattr(solution.system.scene.body(found.body), "whole", found.body)
    return next((each.body for each in turning_frames(solution) if each.force > 0 and each.error > FEIGNED_DEFLECTION), "")


def stays_in_unstable(solution: Solution) -> Iterator[Caution]:
    """A motion that stays where it is, or moves another way, although small motions about it grow: nothing disturbs it, as in statics."""
    system, n_b, n_q = solution.system, solution.system.n_b, solution.system.n_q
    moves = np.real(solution.q - solution.q[0])
    moved = float(np.max(np.abs(moves[:, :n_b]) * system.weights[:n_b], initial=0.0))
    if moved > LARGEST_MOVE or (moved > MOTION_ROUND_OFF and not may_grow(solution)):
        return
    pencil = real_pencil(pencil_of(solution))
    grows = growth_of(solution, pencil)
    growth = np.exp(min(grows.s.real * _lasting(solution), 700.0)) if grows else 1.0
    if grows is None or not grows.doubtful or growth < DOUBTED_GROWTH:
        return
    row = grows.left @ (2 * grows.s * pencil.mass + pencil.damping)[:n_q, :n_q]
    size = np.abs(grows.right * system.weights[:n_q]).max() / abs(row @ grows.right)
    along = float(np.abs(moves @ row).max() * size)
    if along < max(SHOWN_PART * moved, MOTION_ROUND_OFF):
        yield Caution(
            UNSTABLE,
            f"{grows.told('state')} This motion does not show it, because hardly anything disturbs it: what does becomes "
            f"{growth:.3g} times as large until its end.{REMEDY}",
        )


def _lasting(solution: Solution) -> float:
    """How long loads have been about what they are at the end."""
    curves = solution.system.plan.loads.curve
    values = np.real(solution.system.curves(solution.times)[0])[:, np.unique(curves[curves >= 0]), 0]
    differs = np.any(np.abs(values - values[-1]) > LASTING_LOAD_CHANGE * np.abs(values[-1]), axis=1)
    first = int(np.flatnonzero(differs)[-1]) if differs.any() else 0
    return float(solution.times[-1] - solution.times[first])
