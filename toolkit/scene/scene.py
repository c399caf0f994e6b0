"""A scene as data: points, bodies, joints, loads, design variables, wanted responses; what a user writes."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from functools import lru_cache
from pathlib import Path
from typing import Literal, Self, TypeVar

import numpy as np
from pydantic import Field, model_validator

from toolkit.components.bodies.body import Body
from toolkit.components.bodies.model_body import ModelBody
from toolkit.components.joints.joint import Joint
from toolkit.components.loads.gravity import UniformGravity
from toolkit.components.loads.load import AnyLoad
from toolkit.components.loads.pressure import Pressure
from toolkit.components.markers.component import Component
from toolkit.description.description import Description, InSpace, Registered, number_at, numbers_below
from toolkit.description.design import BodyPoint, Design, DesignEntry, DesignVariable, Point, lettered, numbered
from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import SHORT, InputError, listed, meant
from toolkit.foundation.value_types import Scalar
from toolkit.reduced_model.file import load
from toolkit.reduced_model.frozen_basis import RICHER_PARTS, RicherModel, richer_model
from toolkit.reduced_model.model import ReducedModel, place_parameter
from toolkit.scene.design_variables import variables_of
from toolkit.scene.space import SPACES, Space

GROUPS = ("points", "bodies", "joints", "loads", "responses")
"""Tables of names."""
PLURAL = {"body": "bodies", "point": "points", "joint": "joints", "load": "loads"}


def check_names(
    points: Mapping[str, Point | BodyPoint],
    bodies: Mapping[str, Body],
    joints: Mapping[str, Joint],
    loads: Mapping[str, AnyLoad],
    responses: Mapping[str, Registered],
) -> None:
    """Check all names of a scene.

    Raises
    ------
    InputError
        A name is not legal, or something names a body, point or joint that does not exist.
    """
    groups = {"points": points, "bodies": bodies, "joints": joints, "loads": loads, "responses": responses}
    for group, items in groups.items():
        for name in items:
            _legal(group, name)
    existing = {"body": (*bodies, "ground"), "point": points, "joint": joints, "load": loads}
    for group in ("joints", "loads"):
        for name, component in groups[group].items():
            if isinstance(component, Component):
                for body, point in component.grips:
                    known(body, existing["body"], f"{group}.{name}", "body")
                    known(point, points, f"{group}.{name}", "point")
    for name, each in loads.items():
        if isinstance(each, Pressure):
            known(each.body, bodies, f"loads.{name}", "body")
            if not isinstance(bodies[each.body], ModelBody):
                raise InputError(f"loads.{name} presses on body {each.body!r}, which is not flexible and has no named surfaces.")
    for name, owner in bodies.items():
        for point in owner.named_points():
            known(point, points, f"bodies.{name}", "point")
        for key, wishes in owner.deflected.items() if isinstance(owner, ModelBody) else ():
            for point in wishes:
                known(point, points, f"bodies.{name}.{key}", "point")
    for name, written in points.items():
        if isinstance(written, BodyPoint):
            known(written.body, bodies, f"points.{name}", "body")
    for name, response in responses.items():
        for kind, names in existing.items():
            for used in _named(response, kind):
                known(used, names, f"responses.{name}", kind)


def check_design_names(design: Mapping[str, DesignEntry], where: str = "design") -> None:
    """Check that no design variable is called like a number that it leaves alone: who set that number would move others.

    Raises
    ------
    InputError
        Names the variable.
    """
    for name, entry in design.items():
        own = (entry,) if isinstance(entry, str) else entry.of
        if name.partition(".")[0] in (*GROUPS, "solver") and "." in name and name not in own:
            raise InputError(
                f"{where}.{name}: that is the path of a number, and the variable drives {', '.join(own)} instead. Give it a name without "
                "dots."
            )


def _named(response: Registered, kind: str) -> list[str]:
    """Names that a response, or the one that it looks at over time, gives under the word for one of a kind or for several."""
    found: list[str] = []
    for each in (response, getattr(response, "of", None)):
        for value in (getattr(each, kind, None), getattr(each, PLURAL[kind], None)):
            found += [value] if isinstance(value, str) else value if isinstance(value, tuple) else ()
    return found


def check_dimension(dimension: int, points: Mapping[str, Point | BodyPoint], groups: Mapping[str, Mapping[str, InSpace]]) -> None:
    """Refuse a planar scene with what belongs to space, and the reverse.

    Raises
    ------
    InputError
        Names the point or component.
    """
    for name, point in points.items():
        if not isinstance(point, BodyPoint) and len(point.position()) != dimension:
            raise InputError(
                f"points.{name} has {len(point.position())} coordinates; a scene of dimension {dimension} has {dimension}."
            )
    for group, items in groups.items():
        for name, item in items.items():
            if item.dimension != dimension:
                raise InputError(f"{group}.{name} is for dimension {item.dimension}, the scene has dimension {dimension}.")


def known(name: str, existing: Iterable[str], user: str, kind: str) -> None:
    """Refuse a name that does not exist, and list those that do.

    Raises
    ------
    InputError
        The name does not exist.
    """
    if name not in existing:
        raise InputError(
            f"{user} names {kind} {name!r}, which does not exist{meant(name, existing)}; {PLURAL[kind]} of the scene: "
            f"{', '.join(existing) or 'none'}."
        )


def _legal(group: str, name: str) -> None:
    if set(name) & set("./\0") or not name.strip():
        raise InputError(
            f"{group}.{SHORT.repr(name)} is no legal name: dots and slashes separate the parts of a path. Use letters, digits and _."
        )
    if group == "bodies" and name == "ground":
        raise InputError(
            "a body cannot be called 'ground': that is the inertial frame, which is always there. Choose another name."
        )


T = TypeVar("T")


class Scene(Description):
    """A multibody scene.

    Attributes
    ----------
    units
        Unit system of all numbers.
    dimension
        Of space: 2, or 3.
    points
        Name -> [x, y], in space [x, y, z], or interface point; rods run between points, joints sit at them.
    bodies
        Name -> body; the body `ground` is always there.
    joints
        Name -> joint.
    loads
        Name -> load.
    design
        Short name -> path of a number of points, bodies, joints or loads; or a table of several numbers that it drives.
    responses
        Name -> response.
    solver
        Options of the analyses.
    directory
        Folder that paths of reduced models start from; for a scene file its own.
    """

    units: Literal["mm-t-s", "m-kg-s"]
    dimension: Literal[2, 3] = 2
    points: dict[str, Point | BodyPoint] = Field(default_factory=dict)
    bodies: dict[str, Body]
    joints: dict[str, Joint] = Field(default_factory=dict)
    loads: dict[str, AnyLoad] = Field(default_factory=dict)
    design: dict[str, DesignEntry] = Field(default_factory=dict)
    responses: dict[str, Registered] = Field(default_factory=dict)
    solver: RunOptions = RunOptions()
    directory: Path = Path()

    @model_validator(mode="after")
    def _names(self) -> Self:
        check_names(self.points, self.bodies, self.joints, self.loads, self.responses)
        check_dimension(self.dimension, self.points, {"bodies": self.bodies, "joints": self.joints, "loads": self.loads})
        check_design_names(self.design)
        return self

    @property
    def space(self) -> Space:
        """Record of all in which scenes of its dimension differ from those of the other."""
        return SPACES[self.dimension]

    def model_files(self) -> list[Path]:
        """Files of the reduced models of its bodies, each once."""
        names = dict.fromkeys(body.model for body in self.bodies.values() if isinstance(body, ModelBody))
        return [self.directory / name for name in names]

    @property
    def start_file(self) -> Path | None:
        """Results file in whose last state motions of the scene begin, None if they begin elsewhere."""
        return None if self.solver.start_file is None else self.directory / self.solver.start_file

    def read_files(self) -> list[Path]:
        """Files that analyses of the scene read."""
        return [*self.model_files(), *([] if self.start_file is None else [self.start_file])]

    def model(self, path: str, *parts: str) -> ReducedModel:
        """Reduced model with its invariants and interface points, and other parts on request; each is read once.

        Parameters
        ----------
        path : of the file, relative to the scene's folder; a `RicherModel` stands for the body in more shapes, as the file holds it

        Raises
        ------
        InputError
            The model is in another unit system than the scene, or of another dimension.
        ModelFileError
            The file cannot be used, see `toolkit.reduced_model.file.load`.
        """
        full, richer = os.path.join(self.directory, str(path)), isinstance(path, RicherModel)
        try:
            changed = os.stat(full).st_mtime_ns
        except OSError:
            changed = 0
        model = _load(full, ("interfaces", *parts, *(RICHER_PARTS if richer else ())), changed)
        if model.units != self.units:
            raise InputError(
                f"reduced model {path!r} is in {model.units}, the scene in {self.units}. "
                "State the scene in the units of its models, or build the model anew in those of the scene."
            )
        if model.dimension != self.dimension:
            raise InputError(
                f"reduced model {path!r} has dimension {model.dimension}, the scene {self.dimension}. "
                "Build the model for the scene's dimension, or give the scene (`dimension = 2 or 3`) that of its models."
            )
        return richer_model(model) if richer else model

    @property
    def gravity(self) -> np.ndarray:
        """Sum of all gravity loads, shape (d,), length/time^2."""
        found = [np.array(each.acceleration) for each in self.loads.values() if isinstance(each, UniformGravity)]
        return sum(found, np.zeros(self.dimension))

    def number(self, path: str) -> Scalar:
        """Number at a path; a flexible body's parameter that the scene does not set has its nominal value.

        Raises
        ------
        InputError
            There is no number at the path; lists all paths.
        """
        path = self.path_of(path)
        written = self._written(path)
        if written is not None:
            return written
        nominal = self._parameters_of(path.split(".")[1]) if path.count(".") else {}
        if path not in nominal:
            raise InputError(
                f"there is no number {path!r} in the scene{meant(path, [*self.design, *self.available_paths()])}; available: "
                f"{listed(self.available_paths())}. "
                "Design variables and overrides are paths of such numbers."
            )
        return nominal[path]

    def path_of(self, path: str) -> str:
        """Path as `available_paths` has it: in space x, y and z name the numbers of every vector, and 0 and 1 those of a pair."""
        groups: dict[str, Mapping[str, object]] = {"bodies": self.bodies, "joints": self.joints, "loads": self.loads}
        path = numbered(path, groups) if self.space.named_vectors else path
        known = not path.endswith((".0", ".1")) or self._written(path) is not None
        return path if known else lettered(path, self._numbers_near(path))

    def _written(self, path: str) -> Scalar | None:
        """Number at a path, if the scene writes one there."""
        group, name, *keys = (*path.split("."), "", "")[: 2 + max(0, path.count(".") - 1)]
        items = getattr(self, group) if group in type(self).model_fields else None
        return number_at(items[name], keys) if isinstance(items, dict) and name in items else dict(self.numbers()).get(path)

    def _numbers_near(self, path: str) -> dict[str, Scalar]:
        """Numbers of the item that a path leads into, or of the whole scene if it leads into none."""
        group, name = (*path.split("."), "")[:2]
        items = getattr(self, group) if group in type(self).model_fields else None
        return dict(
            numbers_below(f"{group}.{name}", items[name]) if isinstance(items, dict) and name in items else self.numbers()
        )

    def model_parameters(self) -> dict[str, float]:
        """Paths of the numbers that come from reduced models: parameters, and arc lengths of interface points."""
        return self._parameters_of(*self.bodies, *self.points)

    def _parameters_of(self, *names: str) -> dict[str, float]:
        """Parameters of the reduced models behind bodies and points of these names, with their nominal values, by their paths."""
        found: dict[str, float] = {}
        for name, body in ((name, self.bodies[name]) for name in names if name in self.bodies):
            if isinstance(body, ModelBody):
                model = self.model(body.model)
                places = {place_parameter(interface) for interface in model.interfaces or {}}  # reached through their points
                own = {parameter: value for parameter, value in model.nominal.items() if parameter not in places}
                found |= {f"bodies.{name}.{parameter}": value for parameter, value in own.items()}
        for name, point in ((name, self.points[name]) for name in names if name in self.points):
            owner = self.bodies[point.body] if isinstance(point, BodyPoint) else None
            if isinstance(point, BodyPoint) and isinstance(owner, ModelBody):
                interfaces = self.model(owner.model).interfaces or {}
                place = interfaces.get(point.interface)
                if place is not None and place.arc_length_range[0] < place.arc_length_range[1]:
                    found[f"points.{name}.arc_length"] = float(interfaces[point.interface].arc_length)
        return found

    def available_paths(self) -> list[str]:
        """Paths of all numbers that can be design variables."""
        written = [path for path, _ in self.numbers() if path.split(".")[0] in ("points", "bodies", "joints", "loads")]
        return list(dict.fromkeys([*written, *self.model_parameters()]))

    def with_number(self, path: str, value: Scalar) -> Self:
        """A copy in which one number has another value, real or complex.

        Raises
        ------
        InputError
            There is no number at the path.
        """
        path = self.path_of(path)
        if self._written(path) is None:
            self.number(path)
            group, name, key = path.split(".")
            owner = getattr(self, group)
            changed = owner[name].model_copy(update={key: value}) if group == "points" else _with_extra(owner[name], key, value)
            return self.model_copy(update={group: {**owner, name: changed}})
        return super().with_all({path: value})

    def with_all(self, values: Mapping[str, Scalar]) -> Self:
        """A copy in which several numbers have other values, real or complex."""
        written = {path: value for path, value in values.items() if self._written(path) is not None}
        found = super().with_all(written) if written else self
        for path, value in values.items():
            found = found if path in written else found.with_number(path, value)
        return found

    def paths_of(self, name: str) -> tuple[str, ...]:
        """Paths of the numbers of a design variable, by its short name, or of one number by its path."""
        entry = self.design.get(name, name)
        return tuple(map(self.path_of, (entry,) if isinstance(entry, str) else entry.of))

    def factors_of(self, name: str) -> tuple[float, ...]:
        """Factors by which a design variable drives these numbers."""
        entry = self.design.get(name, name)
        return (1.0,) if isinstance(entry, str) else entry.shares

    def value_of(self, name: str) -> float:
        """Value of a design variable: the first of its numbers over its factor."""
        return self.value_at(self.paths_of(name)[0]) / self.factors_of(name)[0]

    def value_at(self, path: str) -> float:
        """Real part of the number at a path, without an imaginary step."""
        return float(np.real(self.number(path)))

    def moved(self, variable: DesignVariable, step: Scalar) -> Self:
        """A copy in which a design variable has grown by a step, real or complex."""
        found = self
        for path, factor in zip(variable.paths, variable.factors, strict=True):
            written = found._written(path)
            if written is None:
                found = found.with_number(path, found.number(path) + factor * step)
            else:
                found = super(Scene, found).with_all({path: written + factor * step})
        return found

    def design_variables(self, names: list[str] | None = None) -> Design:
        """Design variables by short name or path; by default all that the scene declares.

        Raises
        ------
        InputError
            A name or path is unknown, or leads to a number without derivative; lists those that are possible. Two variables drive the same
            number, or one drives numbers of different units.
        """
        return variables_of(self, self.design if names is None else names)


def _with_extra(body: Body, key: str, value: Scalar) -> Body:
    changed = body.model_copy()
    object.__setattr__(changed, "__pydantic_extra__", {**body.model_values(), key: value})
    return changed


def forget_models() -> None:
    """Read every reduced model anew from here on, so that what a run reads can be counted."""
    _read_before.cache_clear()


@lru_cache(maxsize=32)
def _read_before(_path: str, _changed: int) -> dict[str, ReducedModel]:
    """Store for the parts of a file that were read, as long as the file is the same."""
    return {}


def _load(path: str, parts: tuple[str, ...], changed: int) -> ReducedModel:
    """Reduced model of a file with at least these parts; parts that were read before are not read again."""
    shelf = _read_before(path, changed)
    known = shelf.get(path)
    if known is None or not known.bytes_read.keys() >= set(parts):
        shelf[path] = known = load(Path(path), parts, known)
    return known
