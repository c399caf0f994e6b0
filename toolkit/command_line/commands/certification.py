"""The command `ffrf certify`: how far independent methods agree on the gradients of a scene."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from toolkit.command_line.announcements import Kind, at_work
from toolkit.command_line.arguments import Changes, SceneFile, Static, Variables, design_of, read
from toolkit.command_line.printing import print_record, print_tables, verdict_text
from toolkit.foundation.errors import InputError
from toolkit.foundation.terminal import AsJson, Quiet, answered
from toolkit.foundation.verdict import Verdict
from toolkit.report.answer import Answer, AnswerTable, Record

if TYPE_CHECKING:
    from toolkit.analyses.sensitivity.certificate.certificate import Certificate
    from toolkit.analyses.sensitivity.certificate.fresh_models import FreshGradients
    from toolkit.analyses.sensitivity.run import Run
    from toolkit.report.drawing import Drawing
    from toolkit.scene.scene import Scene


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
    from toolkit.analyses.sensitivity.certificate.certificate import certify as compare
    from toolkit.analyses.sensitivity.methods import with_frames_for_gradients
    from toolkit.analyses.sensitivity.preparation import frozen

    kind: Kind = "static" if static else "transient"
    written = read(scene, changes, quiet)
    names = design_of(written, variables)
    described = with_frames_for_gradients(written, kind, names)
    with at_work("comparing", described, kind, names, quiet, "adjoint") as progress:
        found = compare(described, names, kind, progress)
    afresh = built_afresh(frozen(described, found.exact.solution), names, kind, quiet) if fresh else None
    answer = CertificateAnswer(found, with_doubts_afresh(found.verdict, afresh, found.exact), tolerance, fresh, afresh)
    if as_json:
        print_record(answer, quiet)
    else:
        print_tables(answer)
    with answered():
        if output is not None:
            for figure in answer.figures():
                figure.save_as(output)
        found.check(tolerance)
        check_afresh(afresh, found.exact)
    if not as_json:
        typer.echo(agreement(found, tolerance))
        typer.echo(verdict_text(answer.verdict))


@dataclass(frozen=True)
class CertificateAnswer(Answer):
    """Gradients by independent methods, and by reduced models built afresh where these were asked for and can be built."""

    result: Certificate
    tolerance: float
    fresh: bool
    afresh: FreshGradients | None

    def record(self) -> Record:
        """JSON object."""
        found, rebuilt = self.result, self.afresh
        slopes = {} if rebuilt is None else rebuilt.slopes
        by_fresh = {
            f: {x: {"gradient": each.slope, "uncertainty": each.uncertainty} for x, each in row.items()}
            for f, row in slopes.items()
        }
        return {
            "gradients": found.exact.gradients,
            "relative_differences": found.differences,
            "round_off": found.limits,
            "taylor_rates": found.rates,
            "central_differences": [{"relative_step": step, "largest_relative_difference": value} for step, value in found.curve],
            "along_one_direction": {
                f: {"gradient": found.along[f], "difference": each.slope, "uncertainty": each.uncertainty}
                for f, each in found.quotients.items()
            },
            **self.verdict.record(),
            "fresh_preprocessing": rebuilt and {"gradients": by_fresh, "left_out": rebuilt.left_out, "frozen": rebuilt.frozen},
            "verified": found.verified(self.tolerance),
        }

    def tables(self) -> Iterator[AnswerTable | str]:
        """Gradients with their agreeing digits, Taylor rates, and the V of the differences."""
        found = self.result
        first, *others = [method.replace("-", " ") for method in found.differences]
        gradients = [(f, x, slope) for f, slopes in found.exact.gradients.items() for x, slope in slopes.items()]
        by_method = [*found.differences.values(), found.limits]
        rows = [(f, x, f"{slope:.10g}", *(digits_of(each[f][x]) for each in by_method)) for f, x, slope in gradients]
        yield AnswerTable(["gradient", "by", "direct", f"agreeing digits: {first}", *others, "round-off leaves"], rows)
        rates = [
            (f, "-" if math.isnan(rate) else f"{rate:.2f}" if math.isfinite(rate) else "linear")
            for f, rate in found.rates.items()
        ]
        yield AnswerTable(["response", "Taylor rate (2 if smooth)"], rates)
        quotients = [
            (f, f"{found.along[f]:.10g}", f"{each.slope:.10g}", f"{each.uncertainty:.1e}") for f, each in found.quotients.items()
        ]
        yield AnswerTable(["along one direction", "gradient", "best central difference", "uncertain by"], quotients)
        curve = [(f"{step:.0e}", f"{value:.1e}") for step, value in found.curve]
        yield AnswerTable(["central difference, relative step", "largest relative difference"], curve)
        if self.fresh:
            yield from _tables_afresh(self.afresh, found.exact)

    def figures(self) -> Iterator[Drawing]:
        """Digits, and the V of the differences."""
        from toolkit.report.drawing import certificate_drawing

        yield certificate_drawing(self.result)


def _tables_afresh(found: FreshGradients | None, exact: Run) -> Iterator[AnswerTable | str]:
    """Table of gradients by fresh models, and what is missing in it."""
    if found is None:
        yield "No comparison with reduced models built afresh: the preprocessing is not installed."
        return
    rows = []
    for response, slopes in found.slopes.items():
        for x, fresh in slopes.items():
            slope, mark = exact.gradients[response][x], " (frozen)" if x in found.frozen else ""
            difference = abs(slope - fresh.slope) / abs(slope) if slope else abs(fresh.slope)
            rows.append((response, x + mark, f"{slope:.10g}", f"{fresh.slope:.10g}", f"{difference:.1e}"))
    if found.slopes:
        yield AnswerTable(["gradient", "by", "direct", "models built afresh", "relative difference"], rows)
    for name, reason in found.left_out.items():
        yield f"{name} is not compared with models built afresh: {reason}."
    if found.frozen:
        yield f"{', '.join(found.frozen)}: {next(iter(found.frozen.values()))}."


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
    from toolkit.analyses.sensitivity.certificate.certificate import digits

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


def built_afresh(scene: Scene, names: list[str], kind: Kind, quiet: bool) -> FreshGradients | None:
    """Gradients by fresh models; None where there is no preprocessing to build them."""
    from toolkit.analyses.sensitivity.certificate.fresh_models import fresh_gradients
    from toolkit.foundation.processes import is_installed

    if not is_installed():
        return None
    with at_work("variables, models built afresh", scene, kind, quiet=quiet) as progress:
        return fresh_gradients(scene, names, kind, progress)


def with_doubts_afresh(verdict: Verdict, found: FreshGradients | None, exact: Run) -> Verdict:
    """Verdict with what fresh models say against frozen bases."""
    from toolkit.analyses.sensitivity.certificate.fresh_models import doubts_of_fresh

    return verdict if found is None else Verdict.of([*verdict.warnings, *doubts_of_fresh(found, exact)], verdict.measures)


def check_afresh(found: FreshGradients | None, exact: Run) -> None:
    """Refuse gradients that fresh models contradict.

    Raises
    ------
    DisagreementError
        Names response, variable and both numbers.
    """
    from toolkit.analyses.sensitivity.certificate.certificate import DisagreementError
    from toolkit.analyses.sensitivity.certificate.fresh_models import disagreements

    if found is not None and (wrong := list(disagreements(found, exact))):
        raise DisagreementError(
            "; ".join(wrong)
            + ". Build the reduced model again with ffrf-preprocess if its skin file has changed since; else tighten "
            "solver.tolerance, and report what remains."
        )
