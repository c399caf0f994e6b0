"""Whether a modulus or a density can be meant in its unit system: numbers that no material has are questioned, with what they read as.

Bands in SI units. Moduli of ordinary materials go from 1 kPa (soft gels) over foams, 0.1 MPa, and rubbers, 1 MPa, to 1.2 TPa (diamond);
densities from 1 kg/m^3 (silica aerogel) over foams, 10 kg/m^3, to 22.6 t/m^3 (osmium): Ashby, Materials Selection in Mechanical Design
(2011), charts of modulus against density; CRC Handbook of Chemistry and Physics (osmium); Klein and Cardinale 1993 (diamond, 1.14 TPa).
The extremes that were reported are 10 Pa (hydrogels) and 0.16 kg/m^3 (graphene aerogel, Sun et al. 2013). Beyond a hundred times those
the number is no material's.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from toolkit.foundation.units import unit
from toolkit.foundation.verdict import Caution


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
BEYOND = 100.0
"""How many times beyond all that is known a number is no material's at all."""
STIFFEST = 1e9
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
    return not low / BEYOND <= value * IN_SI[units][band.quantity] <= high * BEYOND


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
        if E_si > STIFFEST * rho_si:
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
