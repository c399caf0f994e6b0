"""A scene compiled without and with its design variables, each when it is first needed, and renewed for other numbers."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from toolkit.analyses.sensitivity.chosen_frames import Choices, Frames, automatic, chosen_frames, with_choices, with_frames
from toolkit.analyses.sensitivity.preparation import Kind, prepare
from toolkit.description.design import Design
from toolkit.scene.changed_numbers import with_numbers
from toolkit.scene.scene import Scene
from toolkit.system.evaluation import FileStates, file_states
from toolkit.system.renewal import renewed
from toolkit.system.system import System
from toolkit.validity.bodies.few_shapes import with_richer_bases


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
    system
        The scene without design variables, where it is compiled already.
    """

    scene: Scene
    names: tuple[str, ...] = ()
    base: Compiled | None = None
    paths: tuple[str, ...] = ()
    system: System | None = None

    @classmethod
    def of(cls, system: System) -> Compiled:
        """A scene without design variables that is compiled already."""
        return cls(system.scene, system=system)

    @cached_property
    def design(self) -> Design:
        """The design variables."""
        return self.scene.design_variables(list(self.names))

    @cached_property
    def files(self) -> FileStates:
        """States of the files of reduced models when they were first asked for; all of one origin share them."""
        return file_states(self.scene) if self.base is None else self.base.files

    def analysed_by(self, kind: Kind, for_gradients: More | None = None) -> Compiled:
        """The same with numbers of frames that an analysis needs, where the scene leaves them to be chosen.

        They are chosen once, at the scene's own numbers, so that its values at other numbers can be compared; where gradients are wanted
        too, `for_gradients` tells the numbers that these need.
        """
        root = self if self.base is None else self.base
        if kind not in root._chosen:
            root._chosen[kind] = chosen_frames(root.scene, kind)
        if for_gradients is None or not root._chosen[kind]:
            return self.chosen(root._chosen[kind])
        if kind not in root._chosen_for_gradients:
            root._chosen_for_gradients[kind] = for_gradients(root, kind, root._chosen[kind])
        return self.chosen(root._chosen_for_gradients[kind])

    def chosen(self, choices: Choices) -> Compiled:
        """The same with numbers of frames that were chosen."""
        key = ("chosen", *sorted(choices.items()))
        return self._other(key, lambda scene: with_choices(scene, choices)) if choices else self

    def of_one_frame(self) -> Compiled:
        """The same with one frame where the number is to be chosen: enough for what is not deformed."""
        frames: dict[str, Frames] = dict.fromkeys(automatic(self.scene), 1)
        return self.reframed(frames) if frames else self

    def reframed(self, frames: Mapping[str, Frames], reduced: bool = False) -> Compiled:
        """The same with other frames in some of its bodies; `reduced` as of `with_frames`."""
        return self._other((reduced, *sorted(frames.items())), lambda scene: with_frames(scene, frames, reduced))

    def enriched(self) -> Compiled:
        """The same with more shapes in bodies whose bases are frozen."""
        return self._other("more shapes", with_richer_bases)

    def _other(self, key: Hashable, change: Callable[[Scene], Scene]) -> Compiled:
        """The same with a changed scene; what that compiles is kept for all other numbers."""
        root = self if self.base is None else self.base
        if key not in root._others:
            root._others[key] = Compiled(change(root.scene), self.names)
        other = root._others[key]
        return other if self is root else Compiled(change(self.scene), self.names, other, self.paths)

    @cached_property
    def _chosen(self) -> dict[Kind, Choices]:
        return {}

    @cached_property
    def _chosen_for_gradients(self) -> dict[Kind, Choices]:
        return {}

    @cached_property
    def decided(self) -> dict[Hashable, Any]:
        """What others have decided for all numbers of the scene, each under a key of its own; all of one origin share it."""
        return {} if self.base is None else self.base.decided

    @cached_property
    def _others(self) -> dict[Hashable, Compiled]:
        return {}

    @cached_property
    def primal(self) -> System:
        """The scene without design variables."""
        if self.system is not None:
            return self.system
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
            There is no such number, or its value is invalid.
        """
        scene, paths = with_numbers(self.scene, numbers)
        root = self if self.base is None else self.base
        return Compiled(scene, self.names, root, tuple(dict.fromkeys([*self.paths, *paths])))


More = Callable[[Compiled, Kind, Choices], Choices]
"""Numbers of frames for gradients, from a scene as it is written and those that its values need."""
