"""A reduced model in other units: the same body, with elastic coordinates that preprocessing would have made in those units.

With the factors f of mass, length, ... every array changes by the factor of its dimension, and by s_k for every elastic coordinate:

    q_k' = s_k q_k,   s_k = f_length if the coordinate moves nodes, 1 if it turns them only
    Z' = f_length Z / [1, s],   T' = T / [1, s],   K' = f_energy K / (s s^T)

So nodal coordinates stay nodal coordinates: displacements in the new length, rotations in rad. Of shapes that do both it does not matter
what they count as, because any s_k is the same body.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields, replace
from typing import Any, TypeVar

import numpy as np

from toolkit.foundation.errors import InputError
from toolkit.foundation.units import LABELLED, NONE, Dimension, dimension_of_label, factor, unit
from toolkit.reduced_model.dependence import Derivatives, SparsePolynomial
from toolkit.reduced_model.frozen_basis import RICHER_PARTS, richer_model
from toolkit.reduced_model.model import OWN_GROUPS, ReducedModel
from toolkit.reduced_model.shapes import Part, letters_of

T = TypeVar("T")
P = TypeVar("P", bound=Part)

LENGTH, MASS, TIME = LABELLED["length"], LABELLED["mass"], LABELLED["time"]
ITEMS: dict[str, Dimension] = {
    "mass": MASS, "first_moment": MASS.times(LENGTH), "inertia": MASS.times(LENGTH.power(2)),
    "gyroscopic": MASS.times(LENGTH.power(2)), "stiffness": LABELLED["energy"], "damping": LABELLED["energy"].times(TIME),
    "stress_operator": LABELLED["stress"], "compliance": LABELLED["energy"], "second_moment": MASS.times(LENGTH.power(2)),
    "stiffening": MASS.times(LENGTH.power(2)),
    "axis": NONE, "stress_per_strain": LABELLED["stress"], "axial_stiffness": LABELLED["force"],
    "bending_stiffness": LABELLED["force"].times(LENGTH.power(2)), "torsional_stiffness": LABELLED["force"].times(LENGTH.power(2)),
    "shear_stiffness": LABELLED["force"], "mass_per_length": MASS.times(LENGTH.power(-1)), "fibre_distance": LENGTH,
    "arc_length": LENGTH, "arc_length_range": LENGTH, "position": LENGTH, "rotation": NONE, "target": LENGTH,
    "nodes": LENGTH, "connectivity": NONE, "held": NONE, "recovery": NONE, "outline": LENGTH, "target_outline": LENGTH,
    "element": NONE, "end": NONE, "fibre": NONE, "edges": NONE, "stress": NONE, "modulus": NONE, "triangles": NONE, "lines": NONE,
    "force": LENGTH.power(2), "moment": LENGTH.power(3),
}  # fmt: skip
"""Dimension of every array, for elastic coordinates that are numbers; rows of `recovery` are lengths and angles in turn."""
CANCELLED_SUM = 1e-9
"""Sum of motions in parts of their magnitudes that round-off leaves of a sum that is zero."""
POLYNOMIALS = ("position", "rotation")
"""Arrays of an interface point whose first axis counts powers of the arc length."""


def converted_model(model: ReducedModel, units: str) -> ReducedModel:
    """Reduced model in another system of units.

    Raises
    ------
    InputError
        The unit system or the unit of a parameter is unknown, or the model lacks the mesh or surface that tells what its coordinates are.
    """
    if model.units == units:
        return model
    found = _converted(model, units, _moving(model))
    if model.richer_invariants is None:
        return found
    known = richer_model(model)
    richer = _converted(known, units, np.ones(known.n_f, bool))
    parts: dict[str, Any] = {name: getattr(richer, name.removeprefix("richer_")) for name in RICHER_PARTS}
    return replace(found, **parts)


def _converted(model: ReducedModel, units: str, moving: np.ndarray) -> ReducedModel:
    """Model in other units without its richer basis; the coordinates `moving` (n_f,) move nodes and do not only turn them."""
    dimensions = {name: dimension_of_label(label, model.units) for name, label in model.nominal_units.items()}
    by = {name: factor(dimensions[name], model.units, units) for name in model.nominal}
    parameter, scale = np.array(list(by.values())), _Scales(model, units, moving)
    groups = dict.fromkeys(["", *OWN_GROUPS.values()])

    def rates(item: str, found: Derivatives) -> Derivatives:
        return _derivatives(found, scale.flat(item), parameter)

    def terms(item: str, found: SparsePolynomial) -> SparsePolynomial:
        return _polynomial(found, scale.flat(item), parameter)

    single: dict[str, Any] = {name: part and scale.part(part) for name, part in _single_parts(model).items()}
    dependences: dict[str, Any] = {
        **{f"{group}derivatives": _each(getattr(model, f"{group}derivatives"), rates) for group in groups},
        **{f"{group}affine": _each(getattr(model, f"{group}affine"), terms) for group in groups},
    }
    return replace(
        model,
        units=units,
        nominal={name: value * by[name] for name, value in model.nominal.items()},
        nominal_units={name: _label(dimensions[name], label, model.units, units) for name, label in model.nominal_units.items()},
        **dependences,
        interfaces=_each(model.interfaces, lambda _, point: scale.part(point, point=True)),
        surface_loads=_each(model.surface_loads, lambda _, load: scale.part(load)),
        piece_loads=_each(model.piece_loads, lambda _, load: scale.part(load)),
        **single,
    )


def _single_parts(model: ReducedModel) -> dict[str, Part | None]:
    names = ("invariants", "stress", "shape", "mesh", "outline", "interior", "elements", "sections", "surface")
    more = ("spin", "left_out_shapes", "pieces")
    return {name: getattr(model, name) for name in (*names, *more)}


def _each(group: Mapping[str, T] | None, change: Callable[[str, T], T]) -> dict[str, T] | None:
    return None if group is None else {name: change(name, item) for name, item in group.items()}


def _label(dimension: Dimension, label: str, source: str, target: str) -> str:
    """Label of the same quantity in another system of units."""
    names = (name for name, each in LABELLED.items() if each == dimension and unit(source, name) == label)
    return unit(target, next(names))


class _Scales:
    """Conversion factors of all entries of a model's arrays."""

    def __init__(self, model: ReducedModel, units: str, moving: np.ndarray) -> None:
        self.model, self.units = model, units
        self.length = factor(LENGTH, model.units, units)
        coordinate = np.where(moving, self.length, 1.0)
        local, spatial = np.tile([self.length] * 2 + [1.0], 2), np.tile([self.length] * 3 + [1.0] * 3, 2)
        widths = {"f": coordinate, "u": local, "v": spatial}
        self.per_axis = {letter: 1 / each for letter, each in widths.items()}
        self.per_axis |= {letter: 1 / np.append(1.0, widths[of]) for letter, of in (("z", "f"), ("w", "u"), ("y", "v"))}
        self.per_axis["q"] = 1 / self._loads(coordinate)

    def _loads(self, coordinate: np.ndarray) -> np.ndarray:
        """Conversion factors of the loads of `LeftOutShapes`, as many as there are."""
        found, d = self.model.left_out_shapes, self.model.dimension
        force, moment, per_time = (
            factor(each, self.model.units, self.units) for each in (LABELLED["force"], LABELLED["energy"], TIME.power(-2))
        )
        pulls = per_time * np.concatenate([np.full(d, self.length), np.ones(d * d), coordinate])
        point = np.repeat([force, moment], [d, 1 if d == 2 else 3])
        points = 0 if found is None else (len(found) - len(pulls)) // len(point)
        return np.concatenate([np.tile(point, points), pulls])

    def part(self, part: P, point: bool = False) -> P:
        """Object of a model with all its arrays converted."""
        shapes = letters_of(part)
        changed = {}
        for item in fields(part):
            array = getattr(part, item.name)
            scale = self.entries(item.name, shapes[item.name], array.shape, point)
            changed[item.name] = array if array.dtype.kind in "iu" else np.asarray(array * scale)
        return type(part)(**changed)

    def entries(self, name: str, letters: str, shape: tuple[int, ...], point: bool = False) -> np.ndarray:
        """Conversion factors of one array, of a shape that fits it."""
        found = np.full(shape, factor(ITEMS[name], self.model.units, self.units))
        for axis, letter in enumerate(letters):
            along = self.per_axis.get(letter, np.ones(shape[axis]))
            if letter == "r":
                along = np.resize([self.length, self.length, 1.0], shape[axis])
            if point and name in POLYNOMIALS and axis == 0:
                along = self.length ** -np.arange(shape[axis], dtype=float)
            found = found * along.reshape([-1 if k == axis else 1 for k in range(len(shape))])
        return found

    def flat(self, item: str) -> np.ndarray:
        """Conversion factors of the flattened array of an item."""
        group, *rest = item.split(".")
        array = self.model.item(item)
        owner: Any = self.model.invariants if not rest else getattr(self.model, group)
        owner = owner[rest[0]] if len(rest) == 2 else owner
        name = rest[-1] if rest else group
        return self.entries(name, letters_of(owner)[name], array.shape, point=group == "interfaces").ravel()


def _moving(model: ReducedModel) -> np.ndarray:
    """Which elastic coordinates move nodes and do not only turn them, (n_f,); the material of solids has no rotations."""
    if model.mesh is not None:
        by_node = model.mesh.recovery[:, 1:].reshape(-1, 3, model.n_f)
        return np.any(by_node[:, :2] != 0, axis=(0, 1))
    if model.pieces is not None:
        return np.arange(model.n_f) % 6 < 3
    if model.outline is not None or (model.surface is not None and len(model.surface.triangles)):
        return np.ones(model.n_f, bool)
    if model.surface is not None:
        return _shifting(model.surface.position[:, :, 1:])
    raise InputError(
        f"reduced model {model.label} was loaded without its mesh or surface, which tells displacements from rotations. Load all its "
        "parts; if its file has none of them, build it again with ffrf-preprocess."
    )


def _shifting(moved: np.ndarray) -> np.ndarray:
    """Which elastic coordinates of spatial beams move nodes and do not only turn them, (n_points, 3, n_f) -> (n_f,)."""
    whole = np.abs(moved).sum(axis=(0, 1))
    return np.abs(moved.sum(axis=0)).max(axis=0) > CANCELLED_SUM * whole


def _derivatives(found: Derivatives, scale: np.ndarray, parameter: np.ndarray) -> Derivatives:
    return replace(found, value=found.value * scale[found.entry] / parameter[found.parameter])


def _polynomial(found: SparsePolynomial, scale: np.ndarray, parameter: np.ndarray) -> SparsePolynomial:
    """Polynomial with converted coefficients c_k' = f_item c_k / prod_j f_kj ** power_kj."""
    term = np.prod(np.append(parameter, 1.0)[found.factor] ** found.power, axis=1)
    return replace(found, value=found.value * scale[found.entry] / term[found.term])
