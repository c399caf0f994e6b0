"""Writing a report: page, figures, tables, numbers and results file in one folder."""

from __future__ import annotations

import json
from pathlib import Path

from toolkit.foundation.errors import InputError
from toolkit.foundation.files.replaced_file import write_whole
from toolkit.joints.rigid_joint import Tie
from toolkit.report import page
from toolkit.report.drawing import Drawing
from toolkit.report.figures.catalogue import FIGURES_IN
from toolkit.report.material import Material, Progress
from toolkit.report.own_folder import PAGE, begin, refuse_foreign_files
from toolkit.report.page import Section
from toolkit.report.sections import motion_sections
from toolkit.report.tables import Table, all_tables
from toolkit.results.results_file import save_results

ANSWERS = ("responses", "gradients")
"""Tables that stand before all pictures."""
_SHORT = 8
"""Lines up to which a table stays in one column of the page."""


def write_report(material: Material, folder: str | Path, title: str, progress: Progress = lambda *_: None) -> Path:
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
    tables = all_tables(material)
    for table in tables:
        table.save(folder / "tables")
    _write(folder / "numbers.json", json.dumps(numbers(material, tables), indent=2, allow_nan=False))
    if material.results.path != folder / "results.h5":
        save_results(material.results, folder / "results.h5")
    drawings = _draw(material, folder / "figures", progress)
    written = [
        Section(table.name, table.title, page.table(table), len(table.head) > 4, len(table.rows) > _SHORT)
        for table in tables
        if table.name != "monitors"
    ]
    answers = [each for each in written if each.name in ANSWERS]
    first, sections = [*answers[:1], _trust(material), *answers[1:]], motion_sections(material, folder, progress)
    sections += [*_figure_sections(drawings, folder / "figures"), *(each for each in written if each not in answers)]
    sections += [_missing(material), _again(material)]
    sections.sort(key=lambda section: section.full)  # columns that nothing interrupts are filled most evenly
    path = folder / PAGE
    _write(path, page.page(title, summary(material), *([each for each in part if each.body] for part in (first, sections))))
    return path


def numbers(material: Material, tables: list[Table]) -> dict[str, object]:
    """Record of all numbers of the report."""
    return {table.name: table.record() for table in tables} | material.results.verdict.record()


def summary(material: Material) -> str:
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


def _draw(material: Material, folder: Path, progress: Progress) -> list[tuple[str, Drawing]]:
    """Draw and save all figures; each with the name of the function that drew it."""
    found = []
    figures = FIGURES_IN[material.scene.space]
    for number, figure in enumerate(figures):
        for drawing in figure(material):
            drawing.save(folder)
            found.append((figure.__name__, drawing))
        progress("figures", number + 1, len(figures))
    return found


def _figure_sections(drawings: list[tuple[str, Drawing]], folder: Path) -> list[Section]:
    """One section per kind of figure."""
    sections = []
    for kind in dict.fromkeys(kind for kind, _ in drawings):
        own = [drawing for name, drawing in drawings if name == kind]
        body = page.pictures([page.picture(folder / f"{each.name}.svg", each.caption) for each in own])
        title = own[0].title if len(own) == 1 else kind.replace("_", " ").capitalize()
        sections.append(Section(kind, title, body, full=False, long=len(own) > 1))
    return sections


def _trust(material: Material) -> Section:
    """Section on whether the numbers of the report can be trusted, and why not."""
    head, *reasons = str(material.results.verdict).splitlines()
    listed = page.bullets([reason.removeprefix("- ") for reason in reasons]) if reasons else ""
    return Section("trust", "Whether to trust these numbers", page.paragraph(head) + listed, full=False, long=True)


def _missing(material: Material) -> Section:
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
    return Section("missing", "Not in this report", "".join(page.paragraph(line) for line in lines), full=False)


def _again(material: Material) -> Section:
    """Section on how to repeat the report."""
    record = material.results.scene
    changes = "".join(f" --set {key}={value}" for key, value in record.changes.items())
    text = "Everything can be computed again from the scene below and the reduced models whose hashes are above, with:"
    command = f"ffrf report scene.toml{changes} --output report"
    scene = record.text or json.dumps(record.table, indent=2)
    return Section("again", "To repeat it", page.paragraph(text) + page.listing(command) + page.listing(scene))


def _write(path: Path, text: str) -> None:
    write_whole(path, text.encode())
