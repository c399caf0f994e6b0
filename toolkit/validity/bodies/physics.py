"""Cautions about what the model leaves out: large deformation in a frame, buckling, and frames that spin too fast for linear bodies."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from toolkit.components.bodies.framed_part import FramedPart
from toolkit.foundation.units import unit
from toolkit.foundation.verdict import MOTION, SPIN, STATES, Caution, check
from toolkit.responses.least_frequency import LeastFrequency, LoadMargin
from toolkit.responses.vibration import OfVibration
from toolkit.scene.resolution import ResolvedScene
from toolkit.system.solution import Solution
from toolkit.validity.bodies.carried_force import turning_frames
from toolkit.validity.bodies.critical_load import Compression, critical_compressions
from toolkit.validity.bodies.critical_speed import critical_speed, too_fast_in_motion
from toolkit.validity.bodies.deformation import LIMIT, Deformation, deformations, divided
from toolkit.validity.bodies.known_chain import has_chain
from toolkit.validity.frame_choice import advice_of_frame

SMALL_ROTATION = 0.05
"""Rotation, rad, of which the growth of the elements is half of `LIMIT` of a displacement at most."""
ROUND_OFF = 1e-9
"""Part of the critical load below which forces compress nothing: what eigenvalues of a stiffness leave of zero."""


@check("large-deformation", STATES)
def large_deformations(solution: Solution) -> Iterator[Caution]:
    """A body leaves the range of small deformations in its frame, or a component that is asked for changes where elements turn.

    Limit: 5 % of its largest displacement, or of the component's scale; a remark in a motion whose answers a softer body hardly
    changes, or a run with more frames, made for gradients.
    Fix: more frames, or a stiffer body.
    """
    length = unit(solution.system.scene.units, "length")
    scene = solution.system.scene
    for body, each in deformations(solution).items():
        if each is not None and each.exceeded:
            yield large_deformations.caution(
                f"{body} leaves the range of small deformations: it turns by up to {each.rotation:.2g} rad in its frame. A corotational "
                f"model would differ by about {each.error:.2g} {length} under the same forces, {each.relative:.1%} of its displacement "
                f"(limit {LIMIT:.0%}){_cause(each)}. ffrf check-deformation computes this error. Fix: "
                f"{divided(scene, body, each.relative / LIMIT)}, or stiffen the body.{advice_of_frame(scene, body)}",
                body=body,
                part=each.relative,
            )


def _cause(found: Deformation) -> str:
    """What makes a body that hardly turns leave the range."""
    return "" if found.rotation > SMALL_ROTATION else ", by what forces along it and torques do to its bending"


@check("critical-load", STATES)
def critical_loads(solution: Solution, lateral: bool = False) -> Iterator[Caution]:
    """A body is compressed near its critical load, or beyond, which linear deformations in a body's own frame do not know.

    Limit: 5 % of lateral deflections, of frequencies, or a tenth of the critical load where elements are not known; a remark where a
    run with more frames, made for gradients, changes no answer by half of that.
    Fix: more floating frames (`frames`), or a stiffer body.

    Parameters
    ----------
    lateral
        Whether anything is asked for that depends on the stiffness across the compression: frequencies, or derivatives that the
        solution does not hold. Otherwise an equilibrium that nothing bends is right below the critical load, and this is no doubt.
    """
    scene = solution.system.scene
    lateral = lateral or any(isinstance(each, OfVibration | LoadMargin | LeastFrequency) for each in scene.responses.values())
    for found in critical_compressions(solution):
        if found.straight and found.missed >= found.feigned and found.load < 1 and not lateral:
            yield critical_loads.caution(_straight(found), doubt=False)
            continue
        if found.load < ROUND_OFF and found.missed >= found.feigned:
            yield critical_loads.caution(_stiffened(found), doubt=False)
            continue
        text = _feigned(found) if found.feigned > found.missed else _buckling(found, solution)
        part = max(found.feigned, found.missed) if found.load < 1 else np.inf
        yield critical_loads.caution(text + advice_of_frame(scene, found.body), body=_written(scene, found.body), part=part)


def _stiffened(found: Compression) -> str:
    return (
        f"forces stiffen {found.body} by up to {found.missed:.0%} too much in these equations, across small loads beside theirs, and "
        "compress it nowhere so that it gives way."
    )


def _straight(found: Compression) -> str:
    return (
        f"{found.body} carries {found.load:.2g} times the critical load, and nothing turns it aside: these numbers hold. "
        f"Whatever would, does it by up to {found.missed:.0%} more than these equations say, and its frequencies are lower."
    )


@check("reference-condition", STATES)
def turning(solution: Solution) -> Iterator[Caution]:
    """A frame turns with one end of its body, and a force along the line through both ends turns with it: deflections across are false.

    Limit: 5 % of the deflection; a remark where a run with more frames, made for gradients, changes no answer by half of that.
    Fix: another `frame`, such as that of the chord, or more frames.

    `critical_loads` says the same of equilibria of plane beams.
    """
    force = unit(solution.system.scene.units, "force")
    for found in turning_frames(solution):
        if found.exceeded and (solution.steps or not has_chain(solution.system.scene, found.body)):
            what = "too large" if found.force > 0 else "too small"
            when = f" at t = {found.time:.4g}" if solution.steps else ""
            how = f"up to about {found.error:.0%} {what}" if found.error < 1 else f"far {what}, or of any size"
            yield turning.caution(
                f"{found.body} has a frame that turns with one of its parts. Forces of {abs(found.force):.4g} {force} along the line "
                f"through {found.chord.first!r} and {found.chord.second!r} turn with it{when}: deflections across this line are {how}."
                f"{advice_of_frame(solution.system.scene, found.body)}",
                body=found.body,
                part=found.error,
            )


def _buckling(found: Compression, solution: Solution) -> str:
    moving, scene = solution.steps > 0, solution.system.scene
    when = f" at t = {found.time:.4g}" if moving else ""
    how = "compressed" if scene.space.rotations_add else "loaded"  # in space forces across it make it give way sideways, too
    if found.load >= 1:
        what = f"it buckles{' if that lasts' if moving else ''}, which these numbers do not show"
    else:
        what = f"lateral deflections are up to {found.missed:.0%} larger than these equations say, and frequencies lower"
    return (
        f"{found.body} is {how}{when} with {found.load:.2g} times the critical load: {what}. Linear FFRF has no geometric stiffness "
        f"of a body in its frame. ffrf check-deformation solves it with elements that turn. Fix: load it less, stiffen it, or "
        f"{_more_parts(scene, found.body)}, which buckle as they should."
    )


def _written(scene: ResolvedScene, body: str) -> str:
    """The body that a scene writes, of one of its parts."""
    found = scene.body(body)
    return found.whole if isinstance(found, FramedPart) else body


def _more_parts(scene: ResolvedScene, body: str) -> str:
    """What has more frames than the body, or than the one that it is a part of."""
    found = scene.body(body)
    if not isinstance(found, FramedPart):
        return "make several bodies in a row of it"
    return f"cut {found.whole} into more frames, of a model with more elements where each has one"


def _feigned(found: Compression) -> str:
    return (
        f"{found.body} is softer under its tension than it should be. These equations make lateral deflections {found.feigned:.0%} too "
        "large or more, and frequencies too low: the frame turns with the ends, and linear FFRF has no geometric stiffness of a body in "
        "its frame. Fix: load it less, stiffen it, or make several bodies in a row of it."
    )


@check("critical-speed", (MOTION, SPIN))
def excessive_speeds(solution: Solution) -> Iterator[Caution]:
    """A body spins faster than the speed from which on its own equations bend it out without bound.

    Limit: its critical speed.
    Fix: `spin_stiffening = true`, several bodies in a row, or a slower spin.
    """
    for body, speed, critical in too_fast_in_motion(solution):
        yield excessive_speeds.caution(
            f"{body} spins with {speed:.4g} rad/s, faster than its critical speed of {critical:.4g} rad/s. Linear FFRF lacks "
            "centrifugal stiffening, so that the body bends out without bound or to a wrong state. Fix: a slower spin, "
            "spin_stiffening = true in its table, or several bodies in a row.",
        )


def speed_limits(scene: ResolvedScene, bodies: Iterable[str]) -> str:
    """What to know of the critical speeds of flexible bodies that spin where a run failed; empty without any."""
    limits: dict[str, float] = {}
    for body in bodies:
        found = scene.body(body)
        name = f"the weakest part of {found.whole}" if isinstance(found, FramedPart) else body
        limits[name] = min(limits.get(name, np.inf), critical_speed(scene, body))
    return " ".join(
        f"A frame that spins faster than {limit:.4g} rad/s, the critical speed of {name}, diverges in linear FFRF "
        "with any step, because centrifugal stiffening is not in it."
        for name, limit in limits.items()
    )
