"""A scene compiled without and with its design variables, each when it is first needed, and renewed for other numbers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

from toolkit.description.design import Design
from toolkit.scene.changed_numbers import with_numbers
from toolkit.scene.scene import Scene
from toolkit.sensitivity.preparation import prepare
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
    """

    scene: Scene
    names: tuple[str, ...] = ()

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
    def primal(self) -> System:
        """The scene without design variables."""
        return prepare(self.scene)

    @cached_property
    def full(self) -> System:
        """The scene with all of them."""
        return prepare(self.scene, list(self.names)) if self.names else self.primal

    def at(self, numbers: Mapping[str, float]) -> Compiled:
        """The same scene at other numbers; what is compiled already is renewed.

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
        found = Compiled(scene, self.names)
        for name in ("primal", "full"):
            if name in self.__dict__:
                found.__dict__[name] = renewed(getattr(self, name), scene, paths)
        if not self.names and "primal" in found.__dict__:
            found.__dict__["full"] = found.primal
        return found
