"""Writing a report: page, figures, tables, numbers and results file in one folder."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import chain
from pathlib import Path

from toolkit.components.joints.rigid_joint import Tie
from toolkit.files.results_file import save_results
from toolkit.foundation.errors import InputError
from toolkit.foundation.files.safe_files import list_own, refuse_foreign, write_whole
from toolkit.render.pictures import file_names
from toolkit.report import page
from toolkit.report.answer import Answer, AnswerTable, Record, write
from toolkit.report.drawing import Drawing
from toolkit.report.figures import FIGURES_IN
from toolkit.report.material import Progress, ReportMaterial
from toolkit.report.page import PageSection
from toolkit.report.sections import motion_sections
from toolkit.report.tables import all_tables

PAGE, KEPT = "report.html", "results.h5"
NAMES = (PAGE, KEPT, "numbers.json", "figures", "tables")
"""Names of what a report writes into its folder, beside pictures of scenes in space."""
BEGUN = "<!DOCTYPE html>\n<p>This report was begun and has not been finished.</p>\n"
ANSWERS = ("responses", "gradients")
"""Tables that stand before all pictures."""
_SHORT = 8
"""Lines up to which a table stays in one column of the page."""


def write_report(material: ReportMaterial, folder: str | Path, title: str, progress: Progress = lambda *_: None) -> Path:
    """Write everything into a folder, which is made if it does not exist; the page last, when all that it shows is there.

    Raises
    ------
    InputError
        The folder cannot be written, or holds files of these names that ffrf has not written.

    Returns
    -------
    path of `report.html`; beside it `figures/` (PNG, SVG), `tables/` (CSV), `numbers.json`, `results.h5`; of a
    motion in space `animation.gif`, `overview.png` and `curves.png` too
    """
    folder = Path(folder)
    refuse_foreign_files(folder, material.results.path)
    try:
        for name in ("figures", "tables"):
            (folder / name).mkdir(parents=True, exist_ok=True)
        begin(folder, material.results.path)
    except OSError as error:
        raise InputError(f"{str(folder)!r} cannot hold a report ({error.strerror}). Give a writable folder.") from error
    if material.results.path != folder / KEPT:
        save_results(material.results, folder / KEPT)
    answer = Report(material, material.results.verdict, progress)
    write(answer, folder, tables="tables", figures="figures")
    written = [
        PageSection(table.name, table.title, page.table(table), len(table.head) > 4, len(table.rows) > _SHORT)
        for table in answer.tables()
        if table.name != "monitors"
    ]
    answers = [each for each in written if each.name in ANSWERS]
    first, sections = [*answers[:1], _trust(material), *answers[1:]], motion_sections(material, folder, progress)
    sections += [*_figure_sections(answer.drawn, folder / "figures"), *(each for each in written if each not in answers)]
    sections += [_missing(material), _again(material)]
    sections.sort(key=lambda section: section.full)  # columns that nothing interrupts are filled most evenly
    text = page.page(title, summary(material), *([each for each in part if each.body] for part in (first, sections)))
    write_whole(folder / PAGE, text.encode())
    return folder / PAGE


@dataclass(frozen=True)
class Report(Answer):
    """Everything about a run."""

    result: ReportMaterial
    progress: Progress

    name = "numbers"

    def record(self) -> Record:
        """JSON object of all tables."""
        return {table.name: table.record() for table in self.tables()} | self.verdict.record()

    def tables(self) -> list[AnswerTable]:
        """Tables that have something in them."""
        return all_tables(self.result)

    def figures(self) -> Iterator[Drawing]:
        """Figures, each drawn once."""
        return chain.from_iterable(self.drawn.values())

    @cached_property
    def drawn(self) -> dict[str, list[Drawing]]:
        """Name of the function that drew them -> figures."""
        found, figures = {}, FIGURES_IN[self.result.scene.space]
        for number, figure in enumerate(figures, 1):
            found[figure.__name__] = figure(self.result)
            self.progress("figures", number, len(figures))
        return found


def summary(material: ReportMaterial) -> str:
    """Summary of the work in a few sentences."""
    results, solution = material.results, material.solution
    what = (
        f"Motion over {solution.times[-1]:g} {results.unit('time')} in {solution.steps} steps, scheme {results.settings['scheme']}"
        if material.moving
        else "Equilibrium under the full load"
    )
    flexible = [f"{name} ({body.stress.shape[1]} stress points)" for name, body in results.bodies.items()]
    joints = sum(
        not isinstance(joint, Tie) for joint in material.scene.joints.values()
    )  # those between the parts of a cut body are nobody's
    parts = f"{len(material.scene.bodies)} bodies, {joints} joints, {len(results.coordinates)} coordinates"
    bodies = f"; flexible: {', '.join(flexible)}" if flexible else ""
    return (
        f"{what}; {results.run['newton_iterations']:g} Newton iterations. The scene has {parts}{bodies}. Units: {results.units}."
    )


def _figure_sections(drawn: dict[str, list[Drawing]], folder: Path) -> list[PageSection]:
    """One section per kind of figure."""
    sections = []
    for kind, own in drawn.items():
        if own:
            body = page.pictures([page.picture(folder / f"{each.name}.svg", each.caption) for each in own])
            title = own[0].title if len(own) == 1 else kind.replace("_", " ").capitalize()
            sections.append(PageSection(kind, title, body, full=False, long=len(own) > 1))
    return sections


def _trust(material: ReportMaterial) -> PageSection:
    """Section on whether the numbers of the report can be trusted, and why not."""
    head, *reasons = str(material.results.verdict).splitlines()
    listed = page.bullets([reason.removeprefix("- ") for reason in reasons]) if reasons else ""
    return PageSection("trust", "Whether to trust these numbers", page.paragraph(head) + listed, full=False, long=True)


def _missing(material: ReportMaterial) -> PageSection:
    """Section on what this report does not contain, and how to get it."""
    lines = []
    if material.results.variables and not material.judges:
        lines.append("Gradients are not compared with other methods here: report the scene itself, with --judges.")
    elif material.results.variables and "complex-step" not in material.judges:
        lines.append("Gradients are not compared with a complex step, which takes its time here: ffrf report --judges does it.")
    if not material.results.design:
        lines.append(
            "There are no derivatives of stress and shape: report the scene itself, or a file written by ffrf sensitivity with the "
            "direct method, and see that the scene has variables in its table [design]."
        )
    if not material.moving:
        lines.append("There are no curves over time, because this is an equilibrium.")
    return PageSection("missing", "Not in this report", "".join(page.paragraph(line) for line in lines), full=False)


def _again(material: ReportMaterial) -> PageSection:
    """Section on how to repeat the report."""
    record = material.results.scene
    changes = "".join(f" --set {key}={value}" for key, value in record.changes.items())
    text = "Everything can be computed again from the scene below and the reduced models whose hashes are above, with:"
    command = f"ffrf report scene.toml{changes} --output report"
    scene = record.text or json.dumps(record.table, indent=2)
    return PageSection("again", "To repeat it", page.paragraph(text) + page.listing(command) + page.listing(scene))


def refuse_foreign_files(folder: Path, own: Path | None = None) -> None:
    """Refuse a folder that holds what a report would overwrite and ffrf has not written there; raises as `refuse_foreign`.

    Parameters
    ----------
    own : results file that the report is about, which may lie there
    """
    refuse_foreign(folder, [*_names(folder, own), *file_names("png", animate=True, film=False)])


def begin(folder: Path, own: Path | None = None) -> None:
    """Mark a folder as that of a report, also if the work is interrupted, so that other commands know what it writes."""
    list_own(folder, _names(folder, own))
    write_whole(folder / PAGE, BEGUN.encode())


def _names(folder: Path, own: Path | None) -> list[str]:
    return [name for name in NAMES if own is None or not _same(folder / name, own)]


def _same(one: Path, other: Path) -> bool:
    return one.exists() and other.exists() and one.samefile(other)
