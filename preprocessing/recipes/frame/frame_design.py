"""All designs of a frame: its parameters, where they stand in frame.toml, and the finite elements at any values of them.

The parameters are named by what they are and what owns them: `youngs_modulus_steel`, `width_leg`, `x_A` of a node A, `length_B` and
`angle_B` of a node at a length and an angle from another, and `damping_mass` and `damping_stiffness` of the whole frame. By Poisson's
ratios and nodes there are derivatives, and by the dimensions of sections that shear deforms; by all others the matrices are polynomials.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial, reduce
from operator import getitem
from typing import Any

import numpy as np

from preprocessing.discretisation.discretisation import DesignSpace, Discretisation
from preprocessing.elements.kinds.beams import BeamPatch, PlanarBeam, SpatialBeam
from preprocessing.elements.section import Patch, Sheared
from preprocessing.recipes.frame.frame_file import ALONG, FrameFile
from preprocessing.recipes.frame.frame_nodes import AXES, POLAR, positions
from preprocessing.recipes.frame.frame_tables import DIMENSIONS, BeamTable

_MATERIAL = {"youngs_modulus": "stress", "density": "density", "poisson_ratio": "none"}
_DAMPING = {"mass": "rate", "stiffness": "time"}
_OF_NODES = ("nodes", "polar_nodes")
_ABOVE = np.array([0.0, 0.0, 1.0])


def places(file: FrameFile) -> dict[str, tuple[Any, ...]]:
    """Keys in frame.toml that lead to each parameter."""
    found: dict[str, tuple[Any, ...]] = {
        f"{key}_{name}": ("materials", name, key) for name in file.materials for key in _material(file)
    }
    found |= {f"{key}_{name}": ("sections", name, key) for name, each in file.sections.items() for key in DIMENSIONS[each.kind]}
    found |= {f"damping_{key}": ("damping", key) for key in _DAMPING}
    found |= {
        f"{axis}_{name}": ("nodes", name, number) for name in file.nodes for number, axis in enumerate(AXES[: file.dimension])
    }
    return found | {f"{key}_{name}": ("polar_nodes", name, key) for name in file.polar_nodes for key in POLAR}


def _material(file: FrameFile) -> dict[str, str]:
    """Constants of a material: beams in the plane do not twist, but shear may deform them."""
    return {key: quantity for key, quantity in _MATERIAL.items() if file.dimension == 3 or file.shear or key != "poisson_ratio"}


def quantities(file: FrameFile) -> dict[str, str]:
    """Physical quantity of each parameter, for its unit."""
    found = {}
    for parameter, (table, *rest) in places(file).items():
        if table == "sections":
            found[parameter] = DIMENSIONS[file.sections[rest[0]].kind][rest[1]]
        else:
            found[parameter] = {**_MATERIAL, **_DAMPING, **POLAR}.get(rest[-1], "length")
    return found


def frame_space(file: FrameFile) -> DesignSpace:
    """Design space of the frame."""
    values = _values(file)
    tables = (*_OF_NODES, "sections") if file.shear else _OF_NODES
    by_steps = {name for name, (table, *rest) in places(file).items() if table in tables or rest[-1] == "poisson_ratio"}
    return DesignSpace(values, quantities(file), frozenset(values) - by_steps, partial(frame_elements, file))


def frame_elements(file: FrameFile, design: Mapping[str, Any]) -> Discretisation:
    """Finite elements at one design, which gives every parameter a value, real or complex."""
    beams = frame_beams(file, design)
    at_nodes = {name: node_number(file, point.node) for name, point in file.interface_points.items()}
    return Discretisation(beams, at_nodes)


def node_number(file: FrameFile, name: str) -> int:
    """Number of a named node among all nodes of the elements."""
    return list(file.places).index(name)


def frame_beams(file: FrameFile, design: Mapping[str, Any]) -> SpatialBeam | PlanarBeam:
    """Named nodes, then those between the ends of each beam; elements in the order of the beams."""
    places = positions(file.nodes, file.polar_nodes, design)
    names, corners = list(places), np.array(list(places.values()))
    nodes, connectivity, count = [corners], [], len(corners)
    for beam in file.beams:
        one, two = names.index(beam.start), names.index(beam.end)
        ratio = (np.arange(1, beam.elements) / beam.elements)[:, None]
        nodes.append(corners[one] + ratio * (corners[two] - corners[one]))
        chain = np.array([one, *range(count, count + beam.elements - 1), two])
        connectivity.append(np.column_stack([chain[:-1], chain[1:]]))
        count += beam.elements - 1
    mesh = np.vstack(nodes), np.vstack(connectivity)
    if file.dimension == 2:
        sheared = [_sheared(file, name, design) for name, _ in _sections(file)]
        known = [each for each in sheared if each is not None]
        return PlanarBeam(*mesh, [patch for _, patch in _sections(file)], 1.0, file.rotary_inertia, known)
    given = file.places
    directions = [_orientation(beam, given[beam.end] - given[beam.start]) for beam in file.beams]
    orientation = np.repeat(directions, [beam.elements for beam in file.beams], axis=0)
    return SpatialBeam(*mesh, orientation, _patches(file, design))


def _orientation(beam: BeamTable, along: np.ndarray) -> np.ndarray:
    """Orientation of a beam: as given, or else z; x of beams along z."""
    if beam.orientation is not None:
        return np.array(beam.orientation)
    return np.roll(_ABOVE, 1) if np.linalg.norm(np.cross(along, _ABOVE)) <= ALONG * np.linalg.norm(along) else _ABOVE


def _values(file: FrameFile) -> dict[str, float]:
    """Value of each parameter in the file."""
    content: Any = file.model_dump(by_alias=True)
    return {parameter: reduce(getitem, keys, content) for parameter, keys in places(file).items()}


def _patches(file: FrameFile, design: Mapping[str, Any]) -> list[BeamPatch]:
    """Patches of the elements of every section in space, which also twist."""
    found = []
    for name, patch in _sections(file):
        shear = 1 / (2 * (1 + design[f"poisson_ratio_{file.sections[name].material}"]))
        found.append(BeamPatch(patch, file.sections[name].shape, shear, sheared=_sheared(file, name, design)))
    return found


def _sheared(file: FrameFile, name: str, design: Mapping[str, Any]) -> Sheared | None:
    """Dimensions of a section as numbers, if shear deforms it."""
    section = file.sections[name]
    if not file.shear or section.kappa is None:
        return None
    flexibility = 2 * (1 + design[f"poisson_ratio_{section.material}"]) / section.kappa
    return Sheared({key: design[f"{key}_{name}"] for key in section.dimensions}, flexibility)


def _sections(file: FrameFile) -> Iterator[tuple[str, Patch]]:
    """Sections with their elements, and the parameters that they take their quantities from."""
    section_of = np.repeat([beam.section for beam in file.beams], [beam.elements for beam in file.beams])
    for name, section in file.sections.items():
        own = {key: f"{key}_{name}" for key in section.dimensions}
        own |= {key: f"{key}_{section.material}" for key in ("youngs_modulus", "density")}
        own |= {f"damping_{key}": f"damping_{key}" for key in _DAMPING}
        yield name, Patch(np.flatnonzero(section_of == name), own)
