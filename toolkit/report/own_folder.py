"""The folder of a report: what is there and no command has written is not overwritten."""

from __future__ import annotations

from pathlib import Path

from toolkit.foundation.errors import InputError
from toolkit.foundation.files.own_files import foreign, list_own
from toolkit.foundation.files.replaced_file import write_whole

PAGE, MARK = "report.html", '<meta name="generator" content="ffrf report">'
"""Name of the page, and the line in it by which a report knows its own."""
NAMES = (PAGE, "numbers.json", "results.h5", "figures", "tables", "animation.gif", "overview.png", "curves.png", "step-*.png")
"""What a report writes there."""
BEGUN = f"<!DOCTYPE html>\n{MARK}\n<p>This report was begun and has not been finished.</p>\n"


def refuse_foreign_files(folder: Path, own: Path | None = None) -> None:
    """Refuse a folder that holds what a report would overwrite, unless a command has written it, or a report was written there before.

    Parameters
    ----------
    own : results file that the report is about, which may lie there

    Raises
    ------
    InputError
        It names a file, and what to do.
    """
    page = folder / PAGE
    if page.is_file() and MARK in page.read_text(encoding="utf-8", errors="replace"):
        return
    names = [name for name in NAMES if own is None or not _same(folder / name, own)]
    if (there := foreign(folder, names)) is not None:
        raise InputError(
            f"{str(there)!r} is there, and no command has written it. Give another folder with --output, or move it away."
        )


def _same(one: Path, other: Path) -> bool:
    return one.exists() and other.exists() and one.samefile(other)


def begin(folder: Path) -> None:
    """Make the folder that of a report, also if the work is interrupted, and let other commands know what it writes."""
    list_own(folder, NAMES)
    if not (folder / PAGE).exists():
        write_whole(folder / PAGE, BEGUN.encode())
