"""Options of a run that contradict each other, and why."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import TYPE_CHECKING

from toolkit.foundation.files.meant_path import file_name

if TYPE_CHECKING:
    from toolkit.description.run_options import RunOptions

DAMPED, DAMPED_CHANGING = 0.8, 0.5
"""Largest rho_inf of index 3, and with steps of changing length. Nothing but the scheme damps errors of joint forces there, and curved
paths feed them: they grow from step to step unless a turn has 14, 19, 26, 42, 88 steps at rho_inf = 0.5, 0.6, 0.7, 0.8, 0.9, and with 1
always. What has grown is told by `validity.noisy_forces`."""
STEEPEST = 100.0
"""Shrinking from step to step up to which index 3 and stabilised index 2 are right."""

STARTS, RESULTS = ("given", "equilibrium"), ".h5"
"""Words for a start, and the end of the name of a results file that is one."""
START_SCHEMA = {"anyOf": [{"enum": list(STARTS)}, {"type": "string", "pattern": r"\.h5$"}]}


def known_start(value: str) -> str:
    """Refuse a start that is neither a word nor the name of a results file."""
    if value not in STARTS and not value.endswith(RESULTS):
        raise ValueError(
            f"{value!r} is no start: write {' or '.join(map(repr, STARTS))}, or the name of a results file, which ends in {RESULTS}"
        )
    return file_name(value)


def contradictions(options: RunOptions) -> Iterator[str]:
    """Sentences on options that contradict each other, one for each contradiction."""
    if options.times is not None:
        yield from _of_times(options, options.times)
    if options.scheme == "paper" and (options.local_error is not None or options.formulation != "index-1"):
        yield (
            'scheme = "paper" is of index 1, and has no estimate of its local error; take scheme = "arnold-bruels", or leave out '
            "formulation and local_error"
        )
    if options.quasi_static and options.formulation == "ggl":
        yield (
            'formulation = "ggl" closes the joints by velocities too, which a quasi-static run does not solve for; leave out one of '
            "formulation and quasi_static (a quasi-static run closes them by positions)"
        )
    if options.equilibrium == "spinning" and options.continuation == "arc-length":
        yield 'the steady state of a spin is not followed by arc length; leave out one of equilibrium = "spinning" and continuation'
    if options.equilibrium == "spinning" and options.quasi_static:
        yield (
            "the steady state of a spin is held by inertia, which a quasi-static run leaves out; leave out one of "
            'equilibrium = "spinning" and quasi_static'
        )
    if options.quasi_static and options.start_file is not None:
        yield (
            "a quasi-static run begins in the equilibrium at time 0, so that start can name no results file; leave out one of start and "
            "quasi_static"
        )
    if options.redundant == "least-squares" and options.formulation == "ggl":
        yield (
            'formulation = "ggl" closes every joint twice and cannot leave redundant ones out; take index-1 or index-3, or '
            'redundant = "refuse"'
        )
    changing = options.times is not None or options.local_error is not None
    most = DAMPED_CHANGING if changing else DAMPED
    if options.formulation == "index-3" and options.rho_inf > most:
        yield (
            f'formulation = "index-3"{" with steps of changing length" * changing} needs rho_inf of at most {most:g}: nothing else '
            "damps errors of its joint forces, which grow from step to step where bodies turn, while the motion still looks right; take a "
            "smaller rho_inf, or index-1 or ggl"
        )


def _of_times(options: RunOptions, times: tuple[float, ...]) -> Iterator[str]:
    lengths = [b - a for a, b in pairwise(times)]
    if min(lengths) <= 0 or times[0] != 0 or times[-1] != options.end_time:
        yield f"times must increase from 0 to end_time = {options.end_time:g}; fix them, or leave times out"
    elif options.formulation != "index-1" and any(a > STEEPEST * b for a, b in pairwise(lengths)):
        yield (
            f"times hold a step that is more than {STEEPEST:g} times shorter than the one before: what that left of the joints' "
            "velocities would be a blow; let steps shrink gradually, or take index-1"
        )
    if options.local_error is not None:
        yield "times are given, so that local_error has nothing to choose; leave one of them out"
