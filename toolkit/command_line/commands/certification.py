"""The command `ffrf certify`: how far independent methods agree on the gradients of a scene."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from toolkit.command_line.announcements import Kind, at_work
from toolkit.command_line.arguments import Changes, SceneFile, Static, Variables, design_of, read
from toolkit.command_line.printed.fresh_part import built_afresh, check_afresh, print_afresh, record_afresh, with_doubts_afresh
from toolkit.command_line.printed.printing import WIDE, finite_or_none, print_verdict, table, warn
from toolkit.foundation.errors import InputError
from toolkit.foundation.terminal import AsJson, Quiet, answered, print_json

if TYPE_CHECKING:
    from toolkit.sensitivity.certificate.certificate import Certificate


def certify(
    scene: SceneFile,
    variables: Variables = None,
    static: Static = False,
    tolerance: Annotated[float, typer.Option(min=0, help="Relative difference of exact methods that is an error.")] = 1e-8,
    output: Annotated[
        Path | None, typer.Option(metavar="FILE.png", help="Draw it: digits, and the V of the differences.")
    ] = None,
    fresh: Annotated[
        bool, typer.Option("--fresh/--no-fresh", help="Whether to compare with reduced models built afresh, where they can be.")
    ] = True,
    changes: Changes = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Compare the gradients of independent methods; exit with an error if exact ones disagree."""
    if output is not None:
        refuse_no_picture(output)
    from toolkit.sensitivity.certificate.certificate import certify as compare
    from toolkit.sensitivity.frames_for_gradients import with_frames_for_gradients
    from toolkit.sensitivity.preparation import frozen

    kind: Kind = "static" if static else "transient"
    written = read(scene, changes, quiet)
    names = design_of(written, variables)
    described = with_frames_for_gradients(written, kind, names)
    with at_work("comparing", described, kind, names, quiet, "adjoint") as progress:
        found = compare(described, names, kind, progress)
    afresh = built_afresh(frozen(described, found.exact.solution), names, kind, quiet) if fresh else None
    verdict = with_doubts_afresh(found.verdict, afresh, found.exact)
    if as_json:
        print_json(
            {
                **record_of(found),
                **verdict.record(),
                "fresh_preprocessing": record_afresh(afresh),
                "verified": found.verified(tolerance),
            }
        )
        warn(verdict, quiet)
    else:
        print_certificate(found)
        if fresh:
            print_afresh(afresh, found.exact)
    with answered():
        if output is not None:
            draw(found, output)
        found.check(tolerance)
        check_afresh(afresh, found.exact)
    if not as_json:
        typer.echo(agreement(found, tolerance))
        print_verdict(verdict)


def record_of(found: Certificate) -> dict:
    """JSON object of a certificate."""
    return {
        "gradients": {
            response: {x: finite_or_none(slope) for x, slope in slopes.items()}
            for response, slopes in found.exact.gradients.items()
        },
        "relative_differences": {
            method: {response: {x: finite_or_none(value) for x, value in slopes.items()} for response, slopes in each.items()}
            for method, each in found.differences.items()
        },
        "round_off": {f: {x: finite_or_none(value) for x, value in limits.items()} for f, limits in found.limits.items()},
        "taylor_rates": {response: finite_or_none(rate) for response, rate in found.rates.items()},
        "central_differences": [{"relative_step": step, "largest_relative_difference": value} for step, value in found.curve],
        "along_one_direction": {
            f: {
                "gradient": finite_or_none(found.along[f]),
                "difference": finite_or_none(each.slope),
                "uncertainty": each.uncertainty,
            }
            for f, each in found.quotients.items()
        },
        **found.verdict.record(),
    }


def print_certificate(found: Certificate) -> None:
    """Print gradients with the digits on which adjoint and complex step agree, Taylor rates, and the V of the differences."""
    console = Console(width=WIDE, highlight=False)
    others = [method.replace("-", " ") for method in found.differences]
    gradients = table("gradient", "by", "direct", f"agreeing digits: {others[0]}", *others[1:], "round-off leaves")
    for response, slopes in found.exact.gradients.items():
        for x, slope in slopes.items():
            gradients.add_row(
                response,
                x,
                f"{slope:.10g}",
                *(digits_of(each[response][x]) for each in found.differences.values()),
                digits_of(found.limits[response][x]),
            )
    console.print(gradients)
    rates = table("response", "Taylor rate (2 if smooth)")
    for response, rate in found.rates.items():
        rates.add_row(response, "-" if math.isnan(rate) else f"{rate:.2f}" if math.isfinite(rate) else "linear")
    console.print(rates)
    quotients = table("along one direction", "gradient", "best central difference", "uncertain by")
    for f, each in found.quotients.items():
        quotients.add_row(f, f"{found.along[f]:.10g}", f"{each.slope:.10g}", f"{each.uncertainty:.1e}")
    console.print(quotients)
    curve = table("central difference, relative step", "largest relative difference")
    for step, value in found.curve:
        curve.add_row(f"{step:.0e}", f"{value:.1e}")
    console.print(curve)


def agreement(found: Certificate, tolerance: float) -> str:
    """Sentences on gradients that agree, and on those that round-off leaves fewer digits than the tolerance asks for."""
    worst = {(f, x): max(each[f][x] for each in found.differences.values()) for f, limits in found.limits.items() for x in limits}
    limited = [pair for pair, value in worst.items() if value > tolerance]
    if len(limited) == len(worst) and found.vanish(tolerance):
        return (
            f"All {len(worst)} gradients are next to zero, and all methods find them so to "
            f"{digits_of(max(value for each in found.zeros.values() for value in each.values()))} digits of what a variable of its size "
            "could change: a stationary design."
        )
    agreeing = max((value for pair, value in worst.items() if pair not in limited), default=math.nan)
    text = f"{len(worst) - len(limited)} gradients agree to {digits_of(agreeing)} digits or more."
    if not limited:
        return f"All {text}"
    return (
        f"{text} {len(limited)} more agree as far as round-off lets them: they are zero, or so small beside what they are made of, that "
        "double precision leaves only the digits in the last column."
    )


def digits_of(difference: float) -> str:
    """Number of decimal digits that agree, as text; a dash where a method does not apply."""
    from toolkit.sensitivity.certificate.certificate import digits

    return "-" if math.isnan(difference) else f"{digits(difference):.1f}"


def refuse_no_picture(path: Path) -> None:
    """Refuse a file that cannot become a picture, before the long work begins.

    Raises
    ------
    InputError
        Its name ends otherwise, or its folder does not exist.
    """
    from toolkit.render.packages import require

    require("matplotlib")
    if path.suffix not in (".png", ".svg"):
        raise InputError(f"{str(path)!r} is no picture's name. End it with .png or .svg.")
    if not path.parent.is_dir():
        raise InputError(f"the folder of {str(path)!r} does not exist. Make it first.")


def draw(found: Certificate, path: Path) -> None:
    """Write the picture of a certificate."""
    from toolkit.report.certificate_drawing import certificate_drawing

    certificate_drawing(found).save_as(path)
