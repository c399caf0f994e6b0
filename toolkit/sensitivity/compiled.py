"""A scene compiled without and with its design variables, each when it is first needed, and renewed for other numbers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

from toolkit.description.design import Design
from toolkit.scene.changed_numbers import with_numbers
from toolkit.scene.scene import Scene
from toolkit.sensitivity.preparation import prepare
from toolkit.system.model_files import FileStates, file_states
from toolkit.system.renewal import renewed
from toolkit.system.system import System


@dataclass(frozen=True)
class Compiled:
    """A scene and the names of its design variables.

    Attributes
    ----------
    scene
        The scene.
    names
        Design variables, by short name or path.
    base
        The same scene at its own numbers, which it is made from: one, however many changes there were.
    paths
        Where these numbers differ.
    """

    scene: Scene
    names: tuple[str, ...] = ()
    base: Compiled | None = None
    paths: tuple[str, ...] = ()

    @classmethod
    def of(cls, system: System) -> Compiled:
        """A scene without design variables that is compiled already."""
        found = cls(system.scene)
        found.__dict__["primal"] = system
        return found

    @cached_property
    def design(self) -> Design:
        """The design variables."""
        return self.scene.design_variables(list(self.names))

    @cached_property
    def files(self) -> FileStates:
        """States of the files of reduced models when they were first asked for; all of one origin share them."""
        return file_states(self.scene) if self.base is None else self.base.files

    @cached_property
    def primal(self) -> System:
        """The scene without design variables."""
        return prepare(self.scene) if self.base is None else renewed(self.base.primal, self.scene, list(self.paths))

    @cached_property
    def full(self) -> System:
        """The scene with all of them."""
        if not self.names:
            return self.primal
        if self.base is None:
            return prepare(self.scene, list(self.names))
        return renewed(self.base.full, self.scene, list(self.paths))

    def at(self, numbers: Mapping[str, float]) -> Compiled:
        """The same scene at other numbers: what is compiled here is renewed there.

        Parameters
        ----------
        numbers
            Short name or path of each number -> its value.

        Raises
        ------
        InputError
            There is no such number, or its value cannot be meant.
        """
        scene, paths = with_numbers(self.scene, numbers)
        root = self if self.base is None else self.base
        return Compiled(scene, self.names, root, tuple(dict.fromkeys([*self.paths, *paths])))
