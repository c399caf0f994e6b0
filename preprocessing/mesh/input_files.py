"""Where in an input file an error arose, what a reduced model says about its input files, and where it may be written."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from toolkit.foundation.errors import InputError
from toolkit.reduced_model.file import described_by, hash_of, is_reduced_model
from toolkit.reduced_model.model import ReducedModel


@contextmanager
def at_key(path: Path, key: str) -> Iterator[None]:
    """Add to an input error the file and the key at which it arose."""
    try:
        yield
    except InputError as error:
        raise InputError(f"{str(path)!r}, {key}: {error}") from error


LARGEST_TEXT = 50_000
"""Bytes of a TOML file up to which the model holds its text, to say which keys have changed."""


def with_origin(model: ReducedModel, path: Path, others: Iterable[Path], changes: Mapping[str, float]) -> ReducedModel:
    """Reduced model that says which files it was built from: `inputs`, `source`, `changes` and `inputs_from`.

    Parameters
    ----------
    path : the TOML file that describes it
    others : the files that it names, and those that these draw on
    changes : parameters and values other than those of the file
    """
    content = path.read_bytes()
    return replace(
        model,
        inputs={_relative(each, path): hashlib.sha256(each.read_bytes()).hexdigest() for each in (path, *others)},
        source={path.name: content.decode(errors="replace") if len(content) <= LARGEST_TEXT else ""},
        changes={name: float(value) for name, value in changes.items()},
        inputs_from=path.parent.resolve(),
    )


def _relative(file: Path, path: Path) -> str:
    return Path(os.path.relpath(file, path.parent)).as_posix()


OTHERS = "Name another file with --output, or replace it with --overwrite."


def refuse_output(output: Path, described: Path, inputs: list[Path], input_hash: str, overwrite: bool) -> None:
    """Refuse to write where no model of this body belongs, before anything long begins.

    Parameters
    ----------
    described : the file that describes the body
    inputs : this file, and those that it names; they are never overwritten
    input_hash : of all inputs
    overwrite : whether any other file may be replaced

    Raises
    ------
    InputError
        The output is a folder, an input, not called *.h5, or there already and no model of this body.
    """
    if output.is_dir():
        raise InputError(f"{str(output)!r} is a folder. Name a file in it, for example --output {output / 'skin.h5'}.")
    if any(path.exists() and output.exists() and output.samefile(path) for path in inputs):
        raise InputError(
            f"{str(output)!r} is an input of the model and would be overwritten by it. Name another file with --output."
        )
    if output.suffix != ".h5":
        raise InputError(
            f"{str(output)!r} does not end in .h5, as the name of a reduced model must. Name another file with --output."
        )
    if not output.exists():
        return
    if not output.is_file():
        raise InputError(f"{str(output)!r} is there and is not a regular file. Name another file with --output.")
    if not overwrite:
        _refuse_others(output, described, input_hash)


def refuse_foreign(output: Path, remedy: str) -> None:
    """Refuse to replace a file that is no reduced model.

    Raises
    ------
    InputError
        There is one of that name; `remedy` tells what to do then.
    """
    if output.exists() and not is_reduced_model(output):
        raise InputError(f"{str(output)!r} is there and is not a reduced model, or a damaged one. {remedy}")


def _refuse_others(output: Path, described: Path, input_hash: str) -> None:
    """Refuse to replace a file that is no model, or another body's."""
    refuse_foreign(output, OTHERS)
    sources = [os.path.realpath(output.parent / name) for name in described_by(output)]
    own = Path(os.path.realpath(described))
    same = str(own) in sources if sources else Path(os.path.realpath(output)) == own.with_suffix(".h5")
    if not same and hash_of(output) != input_hash:
        body = f"built from {sources[0]!r}" if sources else "which does not say what it was built from"
        raise InputError(f"{str(output)!r} is there and is the reduced model of another body, {body}. {OTHERS}")
