"""Print every contest as a table; with `--page FILE` write a page of it with date, machine and versions."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path

import numpy as np

from tests.benchmarks.peers import flexible_beam, four_bars
from tests.benchmarks.peers.contest import Contest, Measured, measured

PROGRAMS = ("exudyn", "ffrf-toolkit", "numba", "numpy", "scipy")
PAGE = """# Beside Exudyn

The same scenes in this toolkit and in Exudyn, all settings of both one after the other in every repeat of one run, one core each.
Times are CPU time of the motion alone, without building, compiling or reading, through the call that a user makes; the least of the
repeats. Errors are those of the named quantity at the end of the motion: against the closed form of the linkages, against each program's
own limit of small steps for the beam. **Ratio** is the time beside the fastest setting of Exudyn; compare ratios, not times of
different machines or days. Both programs do what their settings say with the same generalized-alpha method and the same step.

{table}
Measured on {date} on {machine}, {versions}, by `python -m tests.benchmarks.peers`.
"""


def contests(few: bool) -> Iterator[Contest]:
    """From small to large."""
    for count in (2,) if few else (2, 10, 40):
        yield four_bars.contest(count)
    for modes in (4,) if few else (4, 16, 64):
        yield flexible_beam.contest(modes)


def table_of(contest: Contest, ours: list[Measured], exudyn: list[Measured]) -> str:
    """All of ours and the three fastest of Exudyn, as a table in Markdown."""
    best = min(found.microseconds for found in exudyn if found.error < np.inf)
    rows = [*ours, *sorted(exudyn, key=lambda found: found.microseconds)[:3]]
    text = f"## {contest.name}\n\n{round(contest.end_time / contest.step)} steps of {contest.step:g} s; compared: {contest.quantity}.\n"
    if contest.exact is None:
        apart = np.abs(ours[0].limit - rows[len(ours)].limit).max()
        text += f"The limits of small steps of both programs are {apart:.1e} from each other.\n"
    text += "\n| setting | us per step | ratio | error |\n|---|---|---|---|\n"
    for row in rows:
        if not row.error < np.inf:
            text += f"| {row.setting} | did not converge | | |\n"
            continue
        text += f"| {row.setting} | {row.microseconds:.3g} | {row.microseconds / best:.2f} | {row.error:.1e} |\n"
    return text


def machine() -> str:
    """The processor's name."""
    for line in Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            return line.partition(":")[2].strip()
    return "an unnamed processor"


def main() -> None:
    """Measure, print and, if asked, write."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--page", type=Path, help="write the page here")
    options.add_argument("--repeats", type=int, default=5)
    options.add_argument("--few", action="store_true", help="the smallest scenes alone")
    chosen = options.parse_args()
    tables = []
    for contest in contests(chosen.few):
        tables.append(table_of(contest, *measured(contest, chosen.repeats)))
        print(tables[-1], flush=True)
    if chosen.page:
        versions = ", ".join(f"{name} {version(name)}" for name in PROGRAMS)
        page = PAGE.format(table="\n".join(tables), date=f"{datetime.now(UTC):%Y-%m-%d}", machine=machine(), versions=versions)
        chosen.page.write_text(page)


if __name__ == "__main__":
    main()
