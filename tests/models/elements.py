"""One list of all finite elements, each as a small body with closed forms; a new kind is one line of `ELEMENTS`.

No formula of an element stands here: masses are those of points that integrate the body exactly, states of constant strain those of
strength of materials. Every closed form takes complex values, so that its complex step is the derivative.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from preprocessing.builders.discrete_body import lame_factors
from preprocessing.elements.beams import BeamPatch, PlanarBeam, SpatialBeam
from preprocessing.elements.elasticity import SolidMatrices, solid_matrices
from preprocessing.elements.element import Element
from preprocessing.elements.section import Patch
from preprocessing.elements.section import rectangle as rectangle_section
from preprocessing.elements.solid import element_solid
from preprocessing.elements.solid_elements import element_blocks
from preprocessing.elements.stress import stress_rows
from preprocessing.mesh.faces import faces_of, outline_of
from preprocessing.mesh.solid_mesh import SolidMesh
from preprocessing.reduction.assembly import Matrices, Parts, assemble
from tests.models.new_elements import Bar, ShearBeam
from tests.models.solid_bodies import KINDS, SPATIAL_KINDS, box, rectangle

STEP = 1e-30
"""Of complex steps: only the first derivative is left."""
VALUES = {
    "youngs_modulus": 70.0, "density": 2.7, "thickness": 0.3, "width": 0.5, "damping_mass": 0.2, "damping_stiffness": 0.01,
    "poisson_ratio": 0.3, "reach": 1.2,
}  # fmt: skip
"""`reach` multiplies all x of the nodes."""
GAUSS = np.array([-1, 1]) / np.sqrt(12)
"""Places of equal masses that integrate squares over a unit length exactly."""

Values = Mapping[str, Any]


class State(NamedTuple):
    """A state of constant strain."""

    u: np.ndarray  # (nodal,) displacements and rotations of the nodes
    energy: Any  # of strain
    stress: np.ndarray  # (n_stress,)


@dataclass(frozen=True, eq=False)
class Case(ABC):
    """A body of one kind of element."""

    name: str
    values: Mapping[str, float] = field(default_factory=lambda: dict(VALUES))

    @abstractmethod
    def nodes(self, values: Values) -> np.ndarray:
        """Places (n_nodes, d)."""

    @abstractmethod
    def element(self, values: Values) -> Element:
        """The record."""

    @abstractmethod
    def points(self, values: Values) -> tuple[Any, np.ndarray]:
        """The mass of each of (n, d) points that have the body's mass, centre and inertia."""

    @abstractmethod
    def state(self, values: Values) -> State:
        """Constant strain."""

    @property
    @abstractmethod
    def balanced(self) -> np.ndarray:
        """Numbers of the coordinates on which constant strain leaves no force."""

    @cached_property
    def nominal(self) -> Element:
        """The record at the values of the case."""
        return self.element(self.values)

    @cached_property
    def parts(self) -> Parts:
        """Its parts of the matrices."""
        return assemble(self.nominal)

    @cached_property
    def matrices(self) -> Matrices:
        """Its matrices."""
        return self.parts.at(self.values)

    def rate(self, parameter: str) -> Matrices:
        """Derivative of the matrices by one parameter: of the monomials, else by a complex step of the record."""
        if any(parameter in dict(part.factors) for part in self.parts.parts):
            return self.parts.derivative(self.values, parameter)
        stepped = stepped_values(self.values, parameter)
        return assemble(self.element(stepped)).at(self.values).changed(lambda matrix: matrix.imag / STEP)


def stepped_values(values: Values, parameter: str) -> dict[str, Any]:
    return {**values, parameter: values[parameter] + 1j * STEP}


@dataclass(frozen=True, eq=False)
class Straight(Case):
    """Three elements of different lengths in a row, stretched, bent and twisted evenly."""

    make: Callable[[np.ndarray, np.ndarray, Patch, Values], Element] = lambda *_: NotImplemented
    strains: Mapping[str, float] = field(default_factory=dict)
    fibres: tuple[tuple[float, float], ...] = ()  # y_2 / t and y_3 / b of the stress rows of an element
    section: tuple[tuple[float, float], ...] = ((0.0, 0.0),)  # the same of equal masses

    dimension = 2
    stations = np.array([0.0, 0.3, 0.55, 1.0])[:, None]

    def _ends(self, values: Values) -> np.ndarray:
        ends = np.array([[0.4, -0.3, 0.2], [1.4, 1.7, 2.2]])[:, : self.dimension] + 0 * values["reach"]
        return ends * np.append(values["reach"], np.ones(self.dimension - 1))

    def _frame(self, values: Values) -> tuple[Any, np.ndarray]:
        """Length and unit vectors e_1, e_2 (and e_3, in the plane of e_1 and (0.3, -0.2, 1))."""
        one, two = self._ends(values)
        length = np.sqrt(((two - one) ** 2).sum())
        along = (two - one) / length
        if self.dimension == 2:
            return length, np.array([along, [-along[1], along[0]]])
        third = ORIENTATION - (ORIENTATION @ along) * along
        third = third / np.sqrt((third**2).sum())
        return length, np.array([along, np.cross(third, along), third])

    def nodes(self, values: Values) -> np.ndarray:
        one, two = self._ends(values)
        return one + self.stations * (two - one)

    def element(self, values: Values) -> Element:
        patch = Patch(np.arange(3), {name: name for name in self.values})
        return self.make(self.nodes(values), np.column_stack([np.arange(3), np.arange(1, 4)]), patch, values)

    def points(self, values: Values) -> tuple[Any, np.ndarray]:
        (one, two), (length, axes) = self._ends(values), self._frame(values)
        mass = values["density"] * values["thickness"] * values["width"] * length / (2 * len(self.section))
        offsets = np.array([[0 * y, y, z][: self.dimension] for y, z in self._places(self.section, values)]) @ axes
        line = one + (GAUSS + 0.5)[:, None] * (two - one)
        return mass, (line[:, None] + offsets).reshape(-1, self.dimension)

    @staticmethod
    def _places(fractions: tuple[tuple[float, float], ...], values: Values) -> list[tuple[Any, Any]]:
        return [(y * values["thickness"], z * values["width"]) for y, z in fractions]

    def state(self, values: Values) -> State:
        (length, axes), strain = self._frame(values), {"bend_3": 0.0, "twist": 0.0, "shear": 0.0, **self.strains}
        s, t, b, modulus = length * self.stations, values["thickness"], values["width"], values["youngs_modulus"]
        shear_modulus = modulus / (2 * (1 + values["poisson_ratio"]))
        second = strain["bend_2"] * s**2 / 2 + strain["shear"] * s
        moved = np.hstack([strain["stretch"] * s, second, strain["bend_3"] * s**2 / 2][: self.dimension]) @ axes
        turned = strain["bend_2"] * s
        if self.dimension == 3:
            turned = np.hstack([strain["twist"] * s, -strain["bend_3"] * s, strain["bend_2"] * s]) @ axes
        rigidity = {
            "stretch": modulus * t * b,
            "bend_2": modulus * b * t**3 / 12,
            "bend_3": modulus * t * b**3 / 12,
            "twist": shear_modulus * rectangle_section().values({"thickness": t, "width": b})["torsion"],
            "shear": 5 / 6 * shear_modulus * t * b,
        }
        stress = [
            modulus * (strain["stretch"] - y * strain["bend_2"] - z * strain["bend_3"])
            for y, z in self._places(self.fibres, values)
        ]
        energy = length / 2 * sum(rigidity[name] * amount**2 for name, amount in strain.items())
        return State(np.hstack([moved, turned]).ravel(), energy, np.tile(stress, 3))

    @property
    def balanced(self) -> np.ndarray:
        """All of the inner nodes; without their rotations under shear, whose force needs moments."""
        own = 3 if self.dimension == 2 else 6
        kept = self.dimension if "shear" in self.strains else own
        return np.concatenate([own * node + np.arange(kept) for node in (1, 2)])


ORIENTATION = np.array([0.3, -0.2, 1.0])


@dataclass(frozen=True, eq=False)
class StraightInSpace(Straight):
    """The same in space."""

    dimension = 3


@dataclass(frozen=True, eq=False)
class Truss(Case):
    """A triangle of three bars under a constant gradient of the displacement."""

    values: Mapping[str, float] = field(
        default_factory=lambda: {
            name: VALUES[name] for name in ("youngs_modulus", "density", "damping_mass", "damping_stiffness", "reach")
        } | {"area": 0.2}
    )  # fmt: skip
    bars = np.array([[0, 1], [1, 2], [2, 0]])

    def nodes(self, values: Values) -> np.ndarray:
        return np.array([[0.3, 0.1], [2.0, 0.4], [0.9, 1.5]]) * np.array([values["reach"], 1.0])

    def element(self, values: Values) -> Element:
        return Bar(self.nodes(values), self.bars, [Patch(np.arange(3), {name: name for name in self.values})])

    def _bars(self, values: Values) -> tuple[np.ndarray, np.ndarray]:
        one, two = np.moveaxis(self.nodes(values)[self.bars], 1, 0)
        return one, two - one

    def points(self, values: Values) -> tuple[Any, np.ndarray]:
        one, along = self._bars(values)
        mass = values["density"] * values["area"] * np.sqrt((along**2).sum(axis=1)) / 2
        return np.tile(mass, 2), np.vstack([one + (place + 0.5) * along for place in GAUSS])

    def state(self, values: Values) -> State:
        gradient, (_, along) = GRADIENT[:2, :2], self._bars(values)
        strain = np.einsum("ei,ij,ej->e", along, gradient, along) / (along**2).sum(axis=1)
        tension = values["youngs_modulus"] * strain
        energy = values["area"] / 2 * (np.sqrt((along**2).sum(axis=1)) * tension * strain).sum()
        return State((self.nodes(values) @ gradient.T).ravel(), energy, tension)

    @property
    def balanced(self) -> np.ndarray:
        """A triangle has no inner node."""
        return np.zeros(0, int)


GRADIENT = np.array([[0.02, 0.013, -0.01], [-0.005, 0.017, 0.008], [0.012, -0.003, -0.015]])
"""dv_a/dx_b, symmetric and antisymmetric part."""
SHEARED = np.array([[1.0, 0.2, -0.1], [0.1, 0.9, 0.3], [0.0, -0.2, 1.1]])
"""What a rectangle or box is mapped by."""


@dataclass(frozen=True, eq=False)
class Block(Case):
    """A parallelogram or parallelepiped of 2 x 2 (x 2) cells with displaced inner nodes, under a constant gradient."""

    kind: str = ""
    dimension: int = 3
    values: Mapping[str, float] = field(default_factory=lambda: {k: v for k, v in VALUES.items() if k != "thickness"})

    def __post_init__(self) -> None:
        lost = {"reach"} if self.dimension == 2 else {"width"}  # planar bodies have no parameters of their shape
        object.__setattr__(self, "values", {name: value for name, value in self.values.items() if name not in lost})

    def _mesh(self) -> tuple[SolidMesh, np.ndarray]:
        """At reach 1, and the inner nodes."""
        sides = np.array([1.0, 0.8, 0.6])[: self.dimension]
        mesh = rectangle(self.kind, (2, 2), *sides) if self.dimension == 2 else box(self.kind, (2, 2, 2), tuple(sides))
        low, high = mesh.nodes.min(axis=0), mesh.nodes.max(axis=0)
        inner = ((mesh.nodes > low + 1e-9) & (mesh.nodes < high - 1e-9)).all(axis=1)
        pushed = 0.02 * np.random.default_rng(4).uniform(-1, 1, mesh.nodes.shape) * inner[:, None]
        mapped = (mesh.nodes + pushed) @ SHEARED[: self.dimension, : self.dimension].T
        return SolidMesh(mapped, mesh.blocks), np.flatnonzero(inner)

    def _scale(self, values: Values) -> np.ndarray:
        return np.append(values.get("reach", 1.0), np.ones(self.dimension - 1))

    def nodes(self, values: Values) -> np.ndarray:
        return self._mesh()[0].nodes * self._scale(values)

    def _solid(self, values: Values, lame: tuple[Any, Any], motion: np.ndarray | None = None, weight: bool = True) -> Element:
        mesh = SolidMesh(self.nodes(values), self._mesh()[0].blocks)
        blocks, boundary = element_blocks(mesh), (outline_of if self.dimension == 2 else faces_of)(mesh.nodes, mesh.blocks)
        matrices = solid_matrices(blocks, len(mesh.nodes), self.dimension, motion)
        matrices = matrices if weight else SolidMatrices(0 * matrices.scalar_mass, matrices.first, matrices.shear)
        return element_solid(
            mesh.nodes, matrices, stress_rows("xx" if self.dimension == 2 else None, blocks, boundary, motion), lame
        )

    def _lame(self, ratio: Any) -> tuple[Any, Any]:
        return lame_factors(ratio, "plane-stress" if self.dimension == 2 else "space")

    def element(self, values: Values) -> Element:
        return self._solid(values, self._lame(values["poisson_ratio"]))

    def rate(self, parameter: str) -> Matrices:
        values = self.values
        if parameter == "poisson_ratio":
            slopes = [factor.imag / STEP for factor in self._lame(values[parameter] + 1j * STEP)]
            return assemble(self._solid(values, (slopes[0], slopes[1]), weight=False)).at(values)
        if parameter == "reach":
            motion = self.nodes(stepped_values(values, parameter)).imag / STEP
            return assemble(self._solid(values, self._lame(values["poisson_ratio"]), motion)).at(values)
        return super().rate(parameter)

    def _volume(self, values: Values) -> Any:
        sides = 1.0 * 0.8 * values["width"] if self.dimension == 2 else 1.0 * 0.8 * 0.6
        return np.linalg.det(SHEARED[: self.dimension, : self.dimension]) * sides * values.get("reach", 1.0)

    def points(self, values: Values) -> tuple[Any, np.ndarray]:
        grid = np.stack(np.meshgrid(*[GAUSS] * self.dimension, indexing="ij"), axis=-1).reshape(-1, self.dimension)
        places = (grid + [0.5, 0.0, 0.0][: self.dimension]) * [1.0, 0.8, 0.6][: self.dimension]
        places = places @ SHEARED[: self.dimension, : self.dimension].T * self._scale(values)
        return values["density"] * self._volume(values) / len(places), places

    def state(self, values: Values) -> State:
        modulus, ratio, d = values["youngs_modulus"], values["poisson_ratio"], self.dimension
        gradient = GRADIENT[:d, :d]
        strain, shear = (gradient + gradient.T) / 2, modulus / (2 * (1 + ratio))
        first = modulus * ratio / ((1 - ratio**2) if d == 2 else (1 + ratio) * (1 - 2 * ratio))
        stress = first * np.trace(strain) * np.eye(d) + 2 * shear * strain
        told = [stress[0, 0]] if d == 2 else [stress[a, b] for a, b in ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))]
        points = self.parts.n_stress // len(told)
        energy = self._volume(values) / 2 * (stress * strain).sum()
        return State((self.nodes(values) @ gradient.T).ravel(), energy, np.tile(told, points))

    @property
    def balanced(self) -> np.ndarray:
        inner = self._mesh()[1]
        return (self.dimension * inner[:, None] + np.arange(self.dimension)).ravel()


OUTER, INNER = (-0.5, 0.0), (0.5, 0.0)
CORNERS = tuple((-side / 2, across / 2) for side in (1, -1) for across in (-1, 1) for _ in ("both", "ends"))
IN_SPACE = {"stretch": 0.02, "bend_2": 0.05, "bend_3": -0.04, "twist": 0.03}
SECTION = tuple((y, z) for y in GAUSS.tolist() for z in GAUSS.tolist())
DEEP = tuple((y, 0.0) for y in GAUSS.tolist())


def _spatial(nodes: np.ndarray, chain: np.ndarray, patch: Patch, values: Values) -> Element:
    own = BeamPatch(patch, rectangle_section(), 1 / (2 * (1 + values["poisson_ratio"])))
    return SpatialBeam(nodes, chain, np.tile(ORIENTATION, (3, 1)), [own])


def _planar(nodes: np.ndarray, chain: np.ndarray, patch: Patch, _: Values) -> Element:
    return PlanarBeam(nodes, chain, [patch])


def _shear(nodes: np.ndarray, chain: np.ndarray, patch: Patch, values: Values) -> Element:
    return ShearBeam(nodes, chain, [patch], 5 / 12 / (1 + values["poisson_ratio"]))


ELEMENTS: list[Case] = [
    Straight("planar beam", make=_planar, strains={"stretch": 0.02, "bend_2": 0.05}, fibres=(OUTER, INNER) * 2),
    StraightInSpace("spatial beam", make=_spatial, strains=IN_SPACE, section=SECTION, fibres=CORNERS),
    *(Block(kind, kind=kind, dimension=2) for kind in KINDS),
    *(Block(kind, kind=kind) for kind in SPATIAL_KINDS),
    Straight("shear beam", make=_shear, strains={"stretch": 0.02, "bend_2": 0.05, "shear": 0.03}, section=DEEP, fibres=(OUTER, INNER)),
    Truss("bar"),
]  # fmt: skip
"""Those of the project, and the two of `new_elements`."""
