"""Studies in TOML: the same objects as in Python, with errors that name the file, the key and what would be right."""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from toolkit.description.validation_messages import messages
from toolkit.foundation.errors import InputError
from toolkit.foundation.files.toml_file import read_toml
from toolkit.foundation.files.toml_kinds import refuse_other
from toolkit.foundation.files.toml_lines import naming_lines
from toolkit.scene_file.reader import responses_from_table
from toolkit.studies.study.study_file import Study

TABLES = frozenset(Study.model_fields) - {"scene", "directory"}
"""First keys of a study file; errors that begin with another one are of the scene."""


def naming_study_lines(study: Study | str | Path) -> AbstractContextManager[None]:
    """Errors about keys of a study file say in which line they stand; a study made in Python has no lines."""
    return nullcontext() if isinstance(study, Study) else naming_lines(Path(study), TABLES)


def read_study(path: str | Path) -> Study:
    """Read a study file.

    Parameters
    ----------
    path
        The file, in TOML.

    Returns
    -------
    study
        The study, checked as far as it can be without its scene.

    Raises
    ------
    InputError
        The file is missing, is no TOML, or a key or value is wrong; all wrong keys are reported at once.
    """
    path = Path(path)
    table = read_toml(path, "a study in TOML")
    refuse_other(table, path, "study")
    with naming_lines(path):
        return _study(table, path)


def _study(table: dict[str, Any], path: Path) -> Study:
    problems: list[str] = []
    responses = responses_from_table(table.get("responses", {}), problems)
    if not problems:
        given = {**table, "responses": responses, "directory": path.parent}
        try:
            return Study.model_validate(given)
        except ValidationError as error:
            problems += messages(error, Study, given, "", {})
    raise InputError("\n".join(f"{path.name}: {problem}" for problem in problems))
