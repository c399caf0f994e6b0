"""The end-to-end part of `ffrf certify`: gradients beside those of reduced models that are built afresh."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import typer
from rich.console import Console

from toolkit.command_line.announcements import Kind, at_work
from toolkit.command_line.printed.printing import WIDE, finite_or_none, table
from toolkit.foundation.verdict import Verdict

if TYPE_CHECKING:
    from toolkit.scene.scene import Scene
    from toolkit.sensitivity.certificate.fresh_models import FreshGradients
    from toolkit.sensitivity.run import Run


def built_afresh(scene: Scene, names: list[str], kind: Kind, quiet: bool) -> FreshGradients | None:
    """Gradients by fresh models; None where there is no preprocessing to build them."""
    from toolkit.foundation.processes.preprocessing_process import is_installed
    from toolkit.sensitivity.certificate.fresh_models import fresh_gradients

    if not is_installed():
        return None
    with at_work("variables, models built afresh", scene, kind, quiet=quiet) as progress:
        return fresh_gradients(scene, names, kind, progress)


def record_afresh(found: FreshGradients | None) -> dict[str, Any] | None:
    """JSON object of the gradients by fresh models."""
    if found is None:
        return None
    slopes = {
        response: {x: {"gradient": finite_or_none(fresh.slope), "uncertainty": fresh.uncertainty} for x, fresh in each.items()}
        for response, each in found.slopes.items()
    }
    return {"gradients": slopes, "left_out": found.left_out, "frozen": found.frozen}


def print_afresh(found: FreshGradients | None, exact: Run) -> None:
    """Print a table of gradients by fresh models, and what is missing in it."""
    if found is None:
        typer.echo("No comparison with reduced models built afresh: the preprocessing is not installed.")
        return
    if found.slopes:
        rows = table("gradient", "by", "direct", "models built afresh", "relative difference")
        for response, slopes in found.slopes.items():
            for x, fresh in slopes.items():
                slope = exact.gradients[response][x]
                difference = abs(slope - fresh.slope) / abs(slope) if slope else abs(fresh.slope)
                mark = " (frozen)" if x in found.frozen else ""
                rows.add_row(response, x + mark, f"{slope:.10g}", f"{fresh.slope:.10g}", f"{difference:.1e}")
        Console(width=WIDE, highlight=False).print(rows)
    for name, reason in found.left_out.items():
        typer.echo(f"{name} is not compared with models built afresh: {reason}.")
    if found.frozen:
        typer.echo(f"{', '.join(found.frozen)}: {next(iter(found.frozen.values()))}.")


def with_doubts_afresh(verdict: Verdict, found: FreshGradients | None, exact: Run) -> Verdict:
    """Verdict with what fresh models say against frozen bases."""
    from toolkit.sensitivity.certificate.fresh_models import doubts_of_fresh

    return verdict if found is None else Verdict.of([*verdict.warnings, *doubts_of_fresh(found, exact)], verdict.measures)


def check_afresh(found: FreshGradients | None, exact: Run) -> None:
    """Refuse gradients that fresh models contradict.

    Raises
    ------
    DisagreementError
        Names response, variable and both numbers.
    """
    from toolkit.sensitivity.certificate.certificate import DisagreementError
    from toolkit.sensitivity.certificate.fresh_models import disagreements

    if found is not None and (wrong := list(disagreements(found, exact))):
        raise DisagreementError(
            "; ".join(wrong)
            + ". Build the reduced model again with ffrf-preprocess if its skin file has changed since; else tighten "
            "solver.tolerance, and report what remains."
        )
