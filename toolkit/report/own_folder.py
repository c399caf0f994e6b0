"""The folder of a report: what is there and ffrf has not written is not overwritten."""

from __future__ import annotations

from pathlib import Path

from toolkit.foundation.files.own_files import list_own, refuse_foreign
from toolkit.foundation.files.replaced_file import write_whole
from toolkit.render.pictures import file_names

PAGE, KEPT = "report.html", "results.h5"
NAMES = (PAGE, KEPT, "numbers.json", "figures", "tables")
"""Names of what a report writes into its folder, beside pictures of scenes in space."""
BEGUN = "<!DOCTYPE html>\n<p>This report was begun and has not been finished.</p>\n"


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
