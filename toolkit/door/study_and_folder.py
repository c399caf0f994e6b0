"""What every function of a study is given: the study, and the folder in which designs are kept."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from toolkit.foundation.errors import InputError
from toolkit.studies.study.study_file import Study
from toolkit.studies.study.study_reader import naming_study_lines, read_study


@contextmanager
def study_of(study: Study | str | Path) -> Iterator[Study]:
    """Study, read from its file unless it is one already; errors about keys of the file name their line."""
    described = study if isinstance(study, Study) else read_study(study)
    with naming_study_lines(study):
        yield described


def made_folder(path: str | Path | None) -> Path | None:
    """Folder, which is made unless it is there; None stays None.

    Raises
    ------
    InputError
        It cannot be made.
    """
    folder = None if path is None else Path(path)
    if folder is not None:
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(f"{str(folder)!r} cannot be made a folder ({error.strerror}). Give another output.") from error
    return folder
