"""All designs of a skin: its parameters, and the finite elements at any values of them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from preprocessing.discretisation.discretisation import DesignSpace, Discretisation
from preprocessing.elements.block_element import LineElement
from preprocessing.elements.kinds.beams import BeamPatch, PlanarBeam, SpatialBeam
from preprocessing.elements.patches import distribute
from preprocessing.elements.section import Patch
from preprocessing.elements.section_shape import rectangle, strip
from preprocessing.input.at_key import at_key
from preprocessing.mesh.curve_mesh import CurveMesh
from preprocessing.recipes.skin.geometry import Geometry, Remark
from preprocessing.recipes.skin.shape_parameters import shape_parameters
from preprocessing.recipes.skin.skin_file import SkinFile
from preprocessing.recipes.skin.skin_tables import Place
from toolkit.foundation.errors import InputError


def spatial_skin(
    mesh: CurveMesh, patches: Iterable[Patch], modulus_factor: Any, poisson_ratio: Any, rotary_inertia: bool
) -> SpatialBeam:
    """Spatial beams along the skin, in the plane z = 0, with the thickness in the plane and the width along z.

    Parameters
    ----------
    modulus_factor : by which E is multiplied in stretching and bending
    poisson_ratio : for G in torsion
    rotary_inertia : whether the mass is spread over the thickness
    """
    across = np.tile([0.0, 0.0, 1.0], (len(mesh.connectivity), 1))
    shape = rectangle() if rotary_inertia else strip()
    own = [BeamPatch(patch, shape, 1 / (2 * (1 + poisson_ratio)), modulus_factor) for patch in patches]
    return SpatialBeam(np.column_stack([mesh.nodes, np.zeros(len(mesh.nodes))]), mesh.connectivity, across, own)


def design_space(path: Path, file: SkinFile, values: Mapping[str, float], geometry: Geometry) -> DesignSpace:
    """Design space of the skin: section, by groups of elements; Poisson's ratio, where it enters; and shape.

    Parameters
    ----------
    values : those of parameters of single elements count, the others stand in `file` already
    """
    body = {**file.section.model_dump(), **file.material.model_dump()}
    body |= {"damping_mass": file.damping.mass, "damping_stiffness": file.damping.stiffness}
    with at_key(path, "groups"):
        parameters = distribute(body, file.groups, file.skin.separate, file.skin.elements)
    section = {name: values.get(name, value) for name, value in parameters.values.items()}
    shape = shape_parameters(file)
    if file.dimension == 3:
        with at_key(path, "section"):
            _refuse_thick(parameters.patches, section)
    in_plane, wide = file.dimension == 2, file.material.state == "plane-strain"
    ratio = {"poisson_ratio": file.material.poisson_ratio or 0.0} if wide or not in_plane else {}

    def discretise(design: Mapping[str, Any]) -> Discretisation:
        moved = {name: design[name] for name in shape if design[name] != shape[name]}
        at = geometry.moved(moved) if moved else geometry
        factor = 1 / (1 - design["poisson_ratio"] ** 2) if wide else 1.0
        places = {name: _arc_length(path, name, place, at) for name, place in file.interface_points.items()}
        beams: LineElement
        if in_plane:
            beams = PlanarBeam(at.mesh.nodes, at.mesh.connectivity, parameters.patches, factor, file.rotary_inertia)
        else:
            beams = spatial_skin(at.mesh, parameters.patches, factor, design["poisson_ratio"], file.rotary_inertia)
        return Discretisation(beams, places, at.arc_lengths, at.target)

    lengths = {name: "none" if name == "y_scale" else "length" for name in shape}
    quantities = {**parameters.quantities, **dict.fromkeys(ratio, "none"), **lengths}
    return DesignSpace({**section, **ratio, **shape}, quantities, frozenset(section), discretise)


def _refuse_thick(patches: Iterable[Patch], section: Mapping[str, float]) -> None:
    """Refuse a skin thicker than wide in space: it twists as a strip whose thickness is its shorter side."""
    for patch in patches:
        thickness, width = (patch.parameters[name] for name in ("thickness", "width"))
        if section[thickness] > section[width]:
            raise InputError(
                f"a skin in space is at least as wide as it is thick, but {thickness} = {section[thickness]:g} and {width} = "
                f"{section[width]:g}. Write the width across the plane of the airfoil."
            )


def differentiable(space: DesignSpace, remark: Remark | None) -> DesignSpace:
    """Design space without the parameters of the shape that have no derivative; `remark` receives the reasons."""
    lost, steps = {}, {}
    for name in space.values:
        if name not in space.in_monomials:
            try:
                steps[name] = space.stepped(name)
                steps[name].interface_rows()
            except InputError as error:
                lost[name] = str(error)
                if remark is not None:
                    remark(f"the model will have no derivatives by {name}: {error}")
    values, discretise = space.values, space.discretise
    return replace(
        space,
        values={name: value for name, value in values.items() if name not in lost},
        quantities={name: meaning for name, meaning in space.quantities.items() if name not in lost},
        discretise=lambda design: discretise({**values, **design}),
        steps=steps,
    )


def _arc_length(path: Path, name: str, place: Place, geometry: Geometry) -> Any:
    with at_key(path, f"interface_points.{name}"):
        return geometry.skin.locate(**place.where, stations=geometry.arc_lengths)
