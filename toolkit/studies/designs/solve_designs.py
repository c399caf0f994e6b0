"""Many designs of a study solved side by side, and what is said where some could not be."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence

from toolkit.foundation.errors import ToolkitError
from toolkit.foundation.verdict import Caution
from toolkit.studies.designs.design_work import DesignJob, DesignWork, WithFiles
from toolkit.studies.engine.executor import SERIAL, Executor, Progress
from toolkit.studies.engine.jobs import run_jobs
from toolkit.studies.engine.outcome import DesignOutcome
from toolkit.studies.engine.store import DesignStore


def solve_designs(
    work: DesignWork, jobs: Sequence[DesignJob], store: DesignStore, executor: Executor = SERIAL, progress: Progress | None = None
) -> list[DesignOutcome]:
    """Outcomes in the order of the designs; equal ones are solved once, and those that the store has are not solved again.

    Parameters and errors are those of `run_jobs`; to a Dask cluster the files that the scene reads are sent too.
    """
    sent = WithFiles.of(work) if executor.dask else work
    found = run_jobs(sent, {job.key: job for job in jobs}, store, executor, progress)
    return [found[job.key] for job in jobs]


class NoDesignError(ToolkitError, ArithmeticError):
    """Not one design of a study could be solved."""


def refuse_all_failed(found: Sequence[DesignOutcome]) -> None:
    """Raise `NoDesignError` with the reasons, if all designs failed."""
    if any(not each.failed for each in found):
        return
    reasons = Counter(each.reason for each in found).most_common(3)
    raise NoDesignError(
        f"not one of {len(found)} designs could be solved.\n"
        + "\n".join(f"{count} times: {reason}" for reason, count in reasons)
        + "\nMend the scene until `ffrf statics` or `ffrf simulate` solves it, or choose other designs."
    )


def failed_designs(found: Sequence[DesignOutcome], meaning: str, doubt: bool) -> Iterator[Caution]:
    """A caution that some designs could not be solved, with what that means and the most frequent reason."""
    reasons = Counter(each.reason for each in found if each.failed)
    if reasons:
        reason, count = reasons.most_common(1)[0]
        text = f"{sum(reasons.values())} of {len(found)} designs could not be solved{meaning} {count} of them: {reason}"
        yield Caution("failed-designs", text, doubt=doubt)
