"""From skin.toml to the reduced model: every step of the preprocessing, in order."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from preprocessing.airfoil.airfoil_format import LARGEST_FILE
from preprocessing.builders.curve_mesh import CurveMesh, load_gmsh
from preprocessing.builders.recipe import Recipe, Remark, Seal
from preprocessing.builders.skin_file import Place, SkinFile, shape_parameters
from preprocessing.builders.skin_geometry import Geometry, read_geometry
from preprocessing.builders.tables import put, validated
from preprocessing.elements.beams import BeamPatch, LineElement, PlanarBeam, SpatialBeam
from preprocessing.elements.section import QUANTITIES, Patch, distribute, rectangle, strip
from preprocessing.mesh.input_files import at_key
from preprocessing.reduction.discretisation import DesignSpace, Discretisation
from preprocessing.reduction.pictured_parts import with_fibres
from preprocessing.reduction.reduced import ELEMENT_PARTS, SECTIONS, ReducedParts, reduce
from toolkit.foundation.errors import InputError, meant
from toolkit.foundation.files.safe_files import meant_path, read_start
from toolkit.reduced_model.model import Mesh, ReducedModel, Shape


def spatial_skin(
    mesh: CurveMesh, patches: Iterable[Patch], modulus_factor: complex, poisson_ratio: complex, rotary_inertia: bool
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

    def discretise(design: Mapping[str, complex]) -> Discretisation:
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


def _arc_length(path: Path, name: str, place: Place, geometry: Geometry) -> complex:
    with at_key(path, f"interface_points.{name}"):
        return geometry.skin.locate(**place.model_dump(), stations=geometry.arc_lengths)


ELEMENTS = "skin.elements"


def with_keys(file: SkinFile, keys: Mapping[str, object], stations: Callable[[], np.ndarray]) -> SkinFile:
    """Skin file with other values of some keys.

    Parameters
    ----------
    keys : key -> value
        A table (`basis`), or a key in one (`skin.elements`). With another number of elements, interface points at nodes and groups
        of elements stay where they are along the skin.
    stations : callable
        Gives the arc lengths of the file's own nodes, (n_nodes,).

    Raises
    ------
    InputError
        A key or a value is invalid, or a group ends where no element of the other mesh does.
    """
    content = file.model_dump(exclude_none=True)
    if isinstance(elements := keys.get(ELEMENTS), int):
        _remesh(file, content, elements, stations)
    for key, value in keys.items():
        put(content, key.split("."), value)
    return validated(SkinFile, content, "the changed skin")


def _remesh(file: SkinFile, content: dict[str, object], elements: int, stations: Callable[[], np.ndarray]) -> None:
    """Restate the interface points and groups that count nodes or elements."""
    own = file.skin.elements
    if file.skin.separate:
        raise InputError("skin.separate: quantities of single elements mean others in another mesh. Leave the key out.")
    for name, place in file.interface_points.items():
        if place.node is not None:
            moved, rest = divmod(place.node * elements, own)
            where = {"arc_length": float(stations()[place.node])} if rest else {"node": moved}
            put(content, ("interface_points", name), where)
    for name, group in file.groups.items():
        first, end = group.elements[0] * elements, (group.elements[1] + 1) * elements
        if first % own or end % own:
            raise InputError(
                f"groups.{name} ends where no element of a mesh of {elements} does. Choose a multiple of {own} elements."
            )
        put(content, ("groups", name, "elements"), [first // own, end // own - 1])


_KEYS = {
    "youngs_modulus": ("material", "youngs_modulus"),
    "density": ("material", "density"),
    "poisson_ratio": ("material", "poisson_ratio"),
    "thickness": ("section", "thickness"),
    "width": ("section", "width"),
    "damping_mass": ("damping", "mass"),
    "damping_stiffness": ("damping", "stiffness"),
    "chord": ("airfoil", "chord"),
    "y_scale": ("airfoil", "y_scale"),
}
"""Keys of the body's own parameters in skin.toml."""


def put_value(content: dict[str, object], file: SkinFile, name: str, value: float) -> None:
    """Give a parameter of the file another value in its content.

    Besides the parameters of the reduced model, `interface_points.C.arc_length` puts an interface point elsewhere. Those of single
    elements, which `[skin] separate` makes, stand nowhere in the file and are left to `patches.distribute`.

    Raises
    ------
    InputError
        A parameter or interface point does not exist, or a value of a single element is invalid.
    """
    keys = _place(file, name)
    if keys and keys[0] == "interface_points":
        put(content, keys, {"arc_length": value})
    elif not keys and not (value > 0 or (value == 0 and name.startswith("damping"))):
        raise InputError(f"the parameter {name!r} cannot be {value!r}; give a positive number.")
    elif keys:
        put(content, keys, value)


def _place(file: SkinFile, name: str) -> tuple[str, ...]:
    """Keys that lead to a parameter in the file; empty for one of a single element."""
    if name in _KEYS:
        return _KEYS[name]
    if name in file.shape:
        return ("shape", name, "height")
    if name.startswith("interface_points.") and name.endswith(".arc_length"):
        point = name.split(".")[1]
        if point in file.interface_points:
            return ("interface_points", point)
    for quantity in QUANTITIES:
        owner = name.removeprefix(f"{quantity}_")
        if owner != name and owner in file.groups and quantity in file.groups[owner].values:
            return ("groups", owner, quantity)
        if owner in map(str, range(file.skin.elements)) and quantity in file.skin.separate:
            return ()
    raise InputError(
        f"skin.toml has no parameter {name!r}{meant(name, _KEYS)}; there are {', '.join(_KEYS)}, "
        f"shape modes ({', '.join(file.shape) or 'none'}), "
        f"quantities of groups such as thickness_NAME ({', '.join(file.groups) or 'no groups'}), of separate elements such as "
        "thickness_0, and interface_points.NAME.arc_length."
    )


_CLAMPED_NODE = {"F": 0, "G": -1}


class SkinRecipe(Recipe[SkinFile, tuple[Geometry, DesignSpace]]):
    """Recipe of a skin cut from an airfoil.

    Remarks are every repair of an airfoil file, every warning about it or the thickness, and every parameter of the shape by which
    there is no derivative.
    """

    name = "skin.toml"
    schema = SkinFile
    seal = Seal(lengths_of_changes=True)

    @classmethod
    def means(cls, content: Mapping[str, object]) -> bool:
        return "airfoil" in content

    @property
    def parts(self) -> tuple[str, ...]:
        picture = "mesh" if self.file.dimension == 2 else "surface"
        basis = self.file.basis
        own = ELEMENT_PARTS + SECTIONS + basis.parts + basis.richer_parts
        return ("invariants", "derivatives", "affine", "interfaces", "stress", "shape", picture, *own)

    def _named(self) -> list[Path]:
        return [self.path.parent / name for name in (self.file.airfoil.file, self.file.airfoil.target)]

    def _content(self, each: Path) -> bytes:
        """Content of an input for the hash: of an airfoil file as much as decides whether it can be used."""
        if each == self.path:
            return super()._content(each)
        with at_key(self.path, "airfoil.file" if each == self.inputs[1] else "airfoil.target"):
            return _airfoil_bytes(each)

    def _hash_mark(self) -> str:
        return "rotary inertia, " if self.file.rotary_inertia else ""

    def _changed(self, values: Mapping[str, float], keys: Mapping[str, object]) -> SkinFile:
        file = validated(SkinFile, self._content_at(values), "the changed design")
        return with_keys(file, keys, lambda: read_geometry(self.path, file).arc_lengths) if keys else file

    def _put(self, content: dict[str, object], parameter: str, value: float) -> None:
        put_value(content, self.file, parameter, value)

    def _designs(self, remark: Remark | None) -> tuple[Geometry, DesignSpace]:
        geometry = read_geometry(self.path, self.file, remark)
        return geometry, differentiable(design_space(self.path, self.file, self.values, geometry), remark)

    def _model(self, designs: tuple[Geometry, DesignSpace]) -> ReducedModel:
        geometry, space = designs
        clamp = self.file.clamp
        found = reduce(space, self.file.basis.choice(), _CLAMPED_NODE[clamp], clamp)
        return _with_shape_and_pictures(found.model(self.file.units), found, geometry)

    def _writers(self) -> dict[str, str]:
        return {"gmsh": load_gmsh().__version__, **super()._writers()}


def _airfoil_bytes(path: Path) -> bytes:
    try:
        return read_start(path, LARGEST_FILE + 1)
    except OSError as error:
        raise InputError(
            f"the airfoil file {str(path)!r} cannot be read ({error.strerror}{meant_path(path, error)}). Fix the path; it is relative to "
            "the TOML file."
        ) from error


def _with_shape_and_pictures(model: ReducedModel, found: ReducedParts, geometry: Geometry) -> ReducedModel:
    """Reduced model with its shape, and for pictures with the mesh in the plane, the surface in space.

    The shape is compared in the plane of the section in both.
    """
    z, mesh, elements = found.basis.z, geometry.mesh, found.space.nominal()
    shape = Shape(elements.positions(z)[:, :2], geometry.target, geometry.arc_lengths)
    model = replace(model, shape=shape)
    if found.richer is not None:
        model = replace(model, richer_shape=replace(shape, position=elements.positions(found.richer.basis.z)[:, :2]))
    if isinstance(elements.element, SpatialBeam):
        return with_fibres(model, found, elements.element)
    return replace(model, mesh=Mesh(mesh.nodes, mesh.connectivity, z, geometry.outline, geometry.target_outline))
