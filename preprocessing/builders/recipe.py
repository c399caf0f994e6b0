"""A TOML file that describes a flexible body, and all that is made of it: what skins, meshed bodies and frames have in common."""

from __future__ import annotations

import hashlib
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar, Generic, NamedTuple, Self, TypeVar

import numpy as np

from preprocessing.builders.tables import InputTable, Keys, put, validated
from preprocessing.foreign_files.child import LARGEST_FILE
from preprocessing.mesh.input_files import at_key, with_origin
from toolkit.foundation.errors import InputError, listed, meant
from toolkit.foundation.files.safe_files import meant_path, read_whole
from toolkit.foundation.files.toml_file import read_toml
from toolkit.reduced_model.file import SCHEMA_VERSION
from toolkit.reduced_model.model import ReducedModel

WRITER_VERSION = "0.1.0"
"""Version of this distribution; part of the input hash, so that a new version builds its files again."""

File = TypeVar("File", bound=InputTable)
Designs = TypeVar("Designs")
"""Finite elements of a body, with what its designs change of them."""
Remark = Callable[[str], None]


class Seal(NamedTuple):
    """Form of what a kind of recipe hashes: as for its first models, so that those are still recognised.

    A file stands behind its length, so that no byte can pass from one to the next unnoticed.
    """

    word: str = ""  # ahead of the versions
    lengths_of_files: bool = True
    lengths_of_changes: bool = False


@dataclass(frozen=True, eq=False)
class Recipe(ABC, Generic[File, Designs]):
    """File that describes a flexible body, with the values in it or with others.

    A new kind is one subclass, which states the facts and the methods that are abstract here, and one line in `build_model.RECIPES`.
    """

    path: Path
    file: File  # its content, with the values and keys below
    values: Mapping[str, float] = field(default_factory=dict)  # parameter -> value other than that of the file
    keys: Mapping[str, object] = field(default_factory=dict)  # key -> value other than that of the file

    name: ClassVar[str]  # of the file, "skin.toml"
    schema: ClassVar[type[Any]]  # its `File`
    seal: ClassVar[Seal]

    @classmethod
    @abstractmethod
    def means(cls, content: Mapping[str, object]) -> bool:
        """Whether a TOML file's content is meant as one of this kind."""

    @property
    @abstractmethod
    def parts(self) -> tuple[str, ...]:
        """Groups that a complete reduced model of the body has."""

    @property
    def warnings(self) -> Sequence[str]:
        """Warnings of contents that may be intended, printed by every run of the command, also where the model is up to date."""
        return ()

    @abstractmethod
    def _named(self) -> Sequence[Path]:
        """Files that the recipe names, and those that these draw on."""

    @abstractmethod
    def _designs(self, remark: Remark | None) -> Designs:
        """Finite elements at all designs."""

    @abstractmethod
    def _model(self, designs: Designs) -> ReducedModel:
        """Reduced model without its hash and inputs, as finite elements and a basis make it; of `writers` those of this body alone."""

    def _hash_mark(self) -> str:
        """Mark in the hash beside its files: physics that a file of the same words had not when its first models were built."""
        return ""

    def _places(self) -> Mapping[str, Keys]:
        """Keys in the file that lead to each parameter."""
        return {}

    def _writers(self) -> dict[str, str]:
        """Versions of the libraries that decide on the last digits."""
        return {"numpy": np.__version__}

    @classmethod
    def read(cls, path: str | Path) -> Self:
        """Read and check a file of this kind.

        Raises
        ------
        InputError
            The file is missing, no TOML, or a key is unknown, missing or has an invalid value; every such key is named.
        """
        return cls.of(read_toml(Path(path), f"a {cls.name}"), Path(path))

    @classmethod
    def of(cls, content: Mapping[str, object], path: Path) -> Self:
        """Recipe from the content of the file at `path`; raises as `read`."""
        return cls(path, validated(cls.schema, content, repr(str(path)), path))

    @cached_property
    def inputs(self) -> list[Path]:
        """File of the recipe, files that it names, and files that these draw on."""
        return [self.path, *self._named()]

    def hash(self, changes: Mapping[str, object] | None = None) -> str:
        """SHA-256 of all that the result depends on: the inputs, changes of values and keys, schema and writer version.

        Parameters
        ----------
        changes : parameters and keys with values other than those of this recipe

        Raises
        ------
        InputError
            One of the inputs cannot be read.
        """
        digest = hashlib.sha256(f"{self.seal.word}{self._hash_mark()}schema {SCHEMA_VERSION}, writer {WRITER_VERSION}".encode())
        for content in map(self._content, self.inputs):
            digest.update(_behind_length(content) if self.seal.lengths_of_files else content)
        if changes := {**self.values, **self.keys, **(changes or {})}:
            words = repr(sorted(changes.items())).encode()
            digest.update(_behind_length(words) if self.seal.lengths_of_changes else words)
        return digest.hexdigest()

    def at(self, values: Mapping[str, float] | None = None, keys: Mapping[str, object] | None = None) -> Self:
        """Recipe of the same body at another design, or modelled otherwise.

        Parameters
        ----------
        values : parameter -> value
        keys : key -> value, a table (`basis`) or a key in one (`basis.count`)

        Raises
        ------
        InputError
            A parameter does not exist or has no place in the file, or a value is invalid.
        """
        values, keys = values or {}, keys or {}
        file = self._changed(values, keys) if values or keys else self.file
        return replace(self, file=file, values={**self.values, **values}, keys={**self.keys, **keys})

    def changed_tables(self, other: Self) -> dict[str, object]:
        """Tables of the other recipe that differ from those of this; only what is not the default in them, unless that is nothing."""
        mine, theirs = (each.file.model_dump(exclude_none=True, by_alias=True) for each in (self, other))
        brief = other.file.model_dump(exclude_none=True, exclude_defaults=True, by_alias=True)
        return {name: brief.get(name) or table for name, table in theirs.items() if table != mine.get(name)}

    def build(self, remark: Remark | None = None) -> ReducedModel:
        """Reduced model of the body.

        Parameters
        ----------
        remark : callable
            Called with every repair and every warning, in words.

        Raises
        ------
        InputError
            A file is missing or is invalid; the message names the file and the key.
        """
        designs = self._designs(remark)
        with at_key(self.path, "basis"):
            model = self._model(designs)
        writers = {"ffrf-toolkit": WRITER_VERSION, **self._writers(), **model.writers}
        return replace(with_origin(model, self.path, self.inputs[1:], self.values), input_hash=self.hash(), writers=writers)

    def _content(self, each: Path) -> bytes:
        """Content of one of the inputs, for the hash."""
        try:
            return read_whole(each, LARGEST_FILE)
        except OSError as error:
            raise InputError(
                f"{str(each)!r} cannot be read ({error.strerror}{meant_path(each, error)}). Fix the path in {self.path.name}; it is "
                "relative to that file."
            ) from error

    def _changed(self, values: Mapping[str, float], keys: Mapping[str, object]) -> File:
        """Content of the file with other values and keys, checked."""
        content = self._content_at(values)
        for key, value in keys.items():
            put(content, key.split("."), value)
        return validated(self.schema, content, repr(str(self.path)))

    def _content_at(self, values: Mapping[str, float]) -> dict[str, object]:
        """Content of the file with other values of parameters, not checked yet."""
        content = self.file.model_dump(exclude_none=True, by_alias=True)
        for name, value in values.items():
            self._put(content, name, value)
        return content

    def _put(self, content: dict[str, object], parameter: str, value: float) -> None:
        """Give a parameter another value."""
        places = self._places()
        if parameter not in places:
            raise InputError(
                f"{str(self.path)!r} has no parameter {parameter!r}{meant(parameter, places)}; there are {listed(places)}."
            )
        put(content, places[parameter], value)


def _behind_length(content: bytes) -> bytes:
    return f" {len(content)} ".encode() + content
