"""Numbers of a reduced model that can hardly be meant, and what its preprocessing has estimated about its mesh.

Whether a modulus or a density can be meant in its unit system: numbers that no material has are questioned, with what they read as.

Bands in SI units. Moduli of ordinary materials go from 1 kPa (soft gels) over foams, 0.1 MPa, and rubbers, 1 MPa, to 1.2 TPa (diamond);
densities from 1 kg/m^3 (silica aerogel) over foams, 10 kg/m^3, to 22.6 t/m^3 (osmium): Ashby, Materials Selection in Mechanical Design
(2011), charts of modulus against density; CRC Handbook of Chemistry and Physics (osmium); Klein and Cardinale 1993 (diamond, 1.14 TPa).
The extremes that were reported are 10 Pa (hydrogels) and 0.16 kg/m^3 (graphene aerogel, Sun et al. 2013). Beyond a hundred times those
the number is no material's.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from toolkit.foundation.errors import InputError
from toolkit.foundation.units import unit
from toolkit.foundation.verdict import Caution
from toolkit.reduced_model.model import ReducedModel

if TYPE_CHECKING:
    from toolkit.foundation.value_types import Record, Scalar


class Band(NamedTuple):
    """Range of plausible values of a material constant, in its SI unit."""

    quantity: str  # of `toolkit.foundation.units`
    ordinary: tuple[float, float]
    extreme: tuple[float, float]
    likely: tuple[float, float]  # of what mechanisms are made of
    readings: dict[str, float]  # unit -> its size in the SI unit, the likeliest first


BANDS = {
    "youngs_modulus": Band(
        "stress", (1e3, 1.3e12), (10.0, 1.3e12), (1e9, 1.3e12), {"Pa": 1.0, "GPa": 1e9, "MPa": 1e6, "kPa": 1e3}
    ),
    "density": Band(
        "density", (1.0, 2.3e4), (0.16, 2.3e4), (500.0, 2.3e4), {"kg/m^3": 1.0, "g/cm^3": 1e3, "t/mm^3": 1e12, "kg/mm^3": 1e9}
    ),
}
"""Beginnings of the names of parameters, and what they can be."""
IN_SI = {"mm-t-s": {"stress": 1e6, "density": 1e12}, "m-kg-s": {"stress": 1.0, "density": 1.0}}
"""Unit system -> quantity -> its unit in SI units."""
IMPOSSIBLE_FACTOR = 100.0
"""How many times beyond all that is known a number is no material's at all."""
LARGEST_SPECIFIC_MODULUS = 1e9
"""Modulus over density, in m^2/s^2, that nothing exceeds: diamond has 3.3e8, where sound goes 18 km/s, carbon nanotubes 8e8."""
SOFTEST = {2500.0: 1e9, 1600.0: 5e5}
"""Density in kg/m^3 above which no material is softer than that many Pa: metals, stones and ceramics (lead has 1.6e10), filled rubbers."""

METALS = {
    "steel": ((190e9, 215e9), (7700.0, 8050.0)),
    "aluminium": ((67e9, 76e9), (2640.0, 2850.0)),
    "titanium": ((100e9, 122e9), (4400.0, 4600.0)),
    "copper": ((108e9, 132e9), (8850.0, 9000.0)),
}
"""Name -> modulus in Pa and density in kg/m^3, of the metal and its usual alloys (Ashby 2011): a modulus with these digits, at this
density, is the metal's in another unit. Soft fillings of that weight (rubbers with barite or tungsten) have other digits."""
MISREAD = (1e3, 1e6, 1e9)
"""Sizes in each other of the units of modulus."""


def material_questions(values: Mapping[str, float], units: str, where: str) -> Iterator[Caution]:
    """Cautions of the parameters of a reduced model.

    Parameters
    ----------
    values : parameter -> value, for example "density_nose"
    units : unit system
    where : whose parameters they are, for the text
    """
    for kind, band in BANDS.items():
        odd = {name: value for name, value in values.items() if name.startswith(kind) and not _within(band, value, units)}
        if odd:
            (name, value), *others = odd.items()
            more = f" (so have {len(others)} more parameters)" if others else ""
            yield Caution(
                f"unit-of-{kind.replace('_', '-')}",
                f"{where}.{name} = {value:g} {unit(units, band.quantity)}{more}: no material has that. {_reading(band, value, units)}",
                doubt=_beyond(band, value, units) or _is_metal(kind, name, values, units),
            )
    yield from _pairs(values, units, where)


def _within(band: Band, value: float, units: str) -> bool:
    low, high = band.ordinary
    return low <= value * IN_SI[units][band.quantity] <= high


def _beyond(band: Band, value: float, units: str) -> bool:
    low, high = band.extreme
    return not low / IMPOSSIBLE_FACTOR <= value * IN_SI[units][band.quantity] <= high * IMPOSSIBLE_FACTOR


def _is_metal(kind: str, name: str, values: Mapping[str, float], units: str) -> bool:
    """Whether a modulus is that of a metal in another unit, by the density beside it."""
    rho = values.get(name.replace(kind, "density", 1), values.get("density"))
    si = IN_SI[units]
    return (
        kind == "youngs_modulus"
        and rho is not None
        and misread_metal(values[name] * si["stress"], rho * si["density"]) is not None
    )


def _reading(band: Band, value: float, units: str) -> str:
    """Likely meaning of a number: the unit in which it would be that of a usual material."""
    own, label = IN_SI[units][band.quantity], unit(units, band.quantity)
    low, high = band.likely
    read = next(((name, size) for name, size in band.readings.items() if low <= value * size <= high and size != own), None)
    if read is None:
        return f"In {units} its unit is {label}: fix the exponent or the units."
    name, size = read
    return f"{value:g} reads as {name}; in {units} its unit is {label}: {value * size / own:g}."


def _pairs(values: Mapping[str, float], units: str, where: str) -> Iterator[Caution]:
    """Moduli and densities that are a material's each, but of no material together."""
    modulus, density = BANDS["youngs_modulus"], BANDS["density"]
    for name, value in values.items():
        mate = name.replace("youngs_modulus", "density", 1)
        rho = values.get(mate, values.get("density"))
        if (
            not name.startswith("youngs_modulus")
            or rho is None
            or not (_within(modulus, value, units) and _within(density, rho, units))
        ):
            continue
        E_si, rho_si = value * IN_SI[units]["stress"], rho * IN_SI[units]["density"]
        told = f"{where}.{name} = {value:g} {unit(units, 'stress')} with a density of {rho:g} {unit(units, 'density')}"
        if E_si > LARGEST_SPECIFIC_MODULUS * rho_si:
            why = f"stiffer for its weight than any material. {_reading(density, rho, units)}"
            yield Caution("unit-of-density", f"{told}: {why}")
            return
        if any(rho_si > heavy and E_si < softest for heavy, softest in SOFTEST.items()):
            metal = misread_metal(E_si, rho_si)
            why = f"softer than any material that is so heavy. {_reading(modulus, value, units)}"
            why += f" With the digits and the density of {metal}, it is that in another unit." if metal else ""
            yield Caution("unit-of-youngs-modulus", f"{told}: {why}", doubt=metal is not None)
            return


def misread_metal(modulus: float, density: float) -> str | None:
    """The metal whose modulus and density, in SI units, these would be in another unit of the modulus."""
    for name, ((softest, stiffest), (lightest, heaviest)) in METALS.items():
        if lightest <= density <= heaviest and any(softest <= modulus * times <= stiffest for times in MISREAD):
            return name
    return None


COARSE_STRESS_ERROR = 0.15
"""Error in the energy norm above which a mesh is questioned.

Where the exact stress is known, with quadratic elements, the largest stress is then off by a tenth or more; estimates of meshes with few
linear elements are too small by up to a half."""


COARSE_ENERGY_ERROR = 0.25
"""The same above which displacements and frequencies are questioned too: the energy is off by its square, a twentieth and more."""


ROUND_OFF = 1e-4
"""Error below which nobody looks for its size: of a body whose exact stress the mesh holds it is round-off."""


def worst_case(model: ReducedModel) -> tuple[str, float] | None:
    """The load case with the largest estimated error; None where nothing was estimated."""
    return max(model.stress_errors.items(), key=lambda each: each[1], default=None)


def told_mesh(model: ReducedModel) -> str:
    """Estimated stress error of the mesh in a sentence; empty where there is none."""
    worst = worst_case(model)
    if worst is None:
        return ""
    of_cases = f"in the energy norm ({worst[0]}, the worst of {len(model.stress_errors)} load cases)"
    if worst[1] < ROUND_OFF:
        return f"stress of this mesh off by less than {100 * ROUND_OFF:g} % {of_cases}"
    return f"stress of this mesh off by some {100 * worst[1]:.2g} % {of_cases}, most of it near {_place(model)}"


def mesh_record(model: ReducedModel) -> Record | None:
    """Estimated stress error of the mesh as numbers with their meanings, for JSON and tables; None where there is none."""
    if not model.stress_errors:
        return None
    return {
        "told": told_mesh(model),
        "measure": "estimated error of the stress in the energy norm, in parts of the stress",
        "cases": dict(model.stress_errors),
        "place": dict(model.stress_error_at),
        "place_unit": unit(model.units, "length"),
    }


def mesh_questions(model: ReducedModel, where: str, doubt: bool = False, limit: float = COARSE_STRESS_ERROR) -> Iterator[Caution]:
    """Caution about a mesh that is too coarse, for its stress or by another limit."""
    worst = worst_case(model)
    if worst is not None and worst[1] > limit:
        yield Caution(
            "coarse-mesh",
            f"{where}: {told_mesh(model)}: more than {limit:.0%}. Mesh it finer there{_advice(model)}, and run "
            "ffrf-preprocess again.",
            doubt,
        )


def _advice(model: ReducedModel) -> str:
    """Advice beside a finer mesh: other elements, unless all of the mesh have nodes between their corners, by their names."""
    kinds = json.loads(str(model.composition.get("elements", "{}")))
    quadratic = bool(kinds) and all(kind[-1:].isdigit() for kind in kinds)
    return "" if quadratic else ", or take elements with nodes between their corners"


def _place(model: ReducedModel) -> str:
    place = ", ".join(f"{value:.4g}" for value in model.stress_error_at.values())
    return f"({place}) {unit(model.units, 'length')}"


EXTREMES = ("least", "largest")
"""Names among `ReducedModel.face_errors` of those under any forces and moments at once; all others are of one force or moment each."""
LOCKING_ERROR = 0.05
"""Error of displacements above which faces are questioned."""


def told_faces(model: ReducedModel) -> str:
    """Errors of the faces between pieces in a sentence; empty of a body that is not in pieces."""
    if not model.face_errors:
        return ""
    least, largest = (model.face_errors[name] for name in EXTREMES)
    single = {name: error for name, error in model.face_errors.items() if name not in EXTREMES}
    worst = max(single, key=lambda name: abs(single[name]))
    return (
        f"faces between pieces change displacements by {100 * least:+.2g} to {100 * largest:+.2g} % under forces and moments at the "
        f"interface points (most by a {worst}: {100 * single[worst]:+.2g} %)"
    )


def face_record(model: ReducedModel) -> Record | None:
    """Errors of the faces between pieces as numbers with their meanings, for JSON; None of a body that is not in pieces."""
    if not model.face_errors:
        return None
    return {
        "told": told_faces(model),
        "measure": "error of the displacements by the faces between pieces, in parts of those of the uncut mesh",
        "cases": dict(model.face_errors),
    }


def face_questions(model: ReducedModel, where: str, doubt: bool = False) -> Iterator[Caution]:
    """Caution about faces between pieces whose error is too large."""
    if max((abs(error) for error in model.face_errors.values()), default=0.0) > LOCKING_ERROR:
        yield Caution(
            "faces-of-pieces",
            f"{where}: {told_faces(model)}: more than {LOCKING_ERROR:.0%}. Cut it into fewer or longer pieces; those with "
            "averaged and with rigid "
            "faces have the truth between them.",
            doubt,
        )


TINY = np.finfo(float).tiny
LEAST = {
    "youngs_modulus": TINY, "density": TINY, "thickness": TINY, "width": TINY, "chord": TINY, "y_scale": TINY, "damping": 0.0,
    "diameter": TINY, "wall": TINY, "area": TINY, "I_y": TINY, "I_z": TINY, "I_p": TINY, "J": TINY,
}  # fmt: skip
"""Least value of parameters of reduced models by the beginnings of their names; others, such as the height of a bump, have none."""
SWAPPED_SIDES_RATIO = 1.2
"""Ratio of the sides of a rectangle up to which the formula for its torsion, which knows the shorter one at the nominal design, is right
to 0.4 % where this one has become the longer."""


def check_parameters(values: Mapping[str, Scalar], nominal: Mapping[str, float], where: str, dimension: int) -> None:
    """Refuse sizes and material constants that no body can have.

    Parameters
    ----------
    values, nominal
        Parameter -> what the scene sets, and what all of the reduced model have.
    where
        Path of the body in the scene, for the text.
    dimension
        Of space.

    Raises
    ------
    InputError
        Names the parameter and what would be right.
    """
    real = {name: float(np.real(value)) for name, value in values.items()}
    for name, value in real.items():
        least = LEAST.get(next((known for known in LEAST if name.startswith(known)), ""), -np.inf)
        if not value > 0 and (least > 0 or value < least) and nominal.get(name, 1.0) >= least:
            raise InputError(f"{where}.{name} = {value:g} must be {'a positive number' if least > 0 else 'zero or positive'}.")
        if name.startswith("poisson_ratio") and not -1 < value < 0.5:
            raise InputError(f"{where}.{name} = {value:g} must be above -1 and below 0.5.")
    here = {**nominal, **real}
    for wall, diameter in _mates(real, here, "wall", "diameter"):
        if 2 * here[wall] > here[diameter] * (1 + 1e-12):  # a full bar, written with decimals
            raise InputError(
                f"{where}: a {wall} of {here[wall]:g} is more than half the {diameter} of {here[diameter]:g}: no tube has that. "
                "Make the wall thinner, or the tube wider."
            )
    for thickness, width in _mates(real, here, "thickness", "width") if dimension == 3 else ():
        sides, built = (each[thickness] / each[width] for each in (here, {**here, **nominal}))
        if (sides if built <= 1 else 1 / sides) > SWAPPED_SIDES_RATIO:
            raise InputError(
                f"{where}: with {thickness} = {here[thickness]:g} and {width} = {here[width]:g} the side is the longer one that was "
                f"the shorter when the reduced model was built ({nominal[thickness]:g} and {nominal[width]:g}); its formula for torsion "
                "does not reach so far. Build it anew with these numbers."
            )


def _mates(changed: Mapping[str, float], all_of: Mapping[str, float], one: str, other: str) -> Iterator[tuple[str, str]]:
    """Pairs of parameters of one section or group, of which the scene sets one; a group without its own has the body's."""
    suffixes = {name.removeprefix(kind) for name in all_of for kind in (one, other) if name.startswith(kind)}
    for suffix in sorted(suffixes):
        pair = tuple(kind + suffix if kind + suffix in all_of else kind for kind in (one, other))
        if all(name in all_of for name in pair) and any(name in changed for name in pair):
            yield pair[0], pair[1]
