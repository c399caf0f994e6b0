"""The same compiled scene with other stiffness in some of its bodies, for what an error of their deflection does to the answers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from toolkit.bodies.body import ConstantNumbers
from toolkit.compilation.plan import Kept, build_plan
from toolkit.compilation.quantities import Quantities
from toolkit.system.flexible_bodies import deforming
from toolkit.system.system import System


def softened(system: System, factors: Mapping[str, float]) -> System:
    """A system whose bodies, or their parts, have so many times their stiffness; stiffness alone, so that forces and masses are the same.

    Parameters
    ----------
    factors
        Name of a flexible body, cut or not -> factor of its stiffness and of the derivatives of that.
    """
    scene = system.scene
    names = list(scene.all_bodies())
    numbers = {
        names.index(part): factor
        for body, factor in factors.items()
        for part, each in deforming(scene).items()
        if body in (part, getattr(each, "whole", None))
    }
    values, changes = _scaled(system.values, numbers), [_scaled(each, numbers) for each in system.derivatives]
    kept = Kept(system.plan, frozenset({"constant"}))
    built = build_plan(scene, system.numbering, values, changes, system.dtype, system.weights, kept)
    return replace(system, plan=system.plan._replace(constant=built.constant), values=values, derivatives=changes)


def _scaled(numbers: Quantities, factors: Mapping[int, float]) -> Quantities:
    constant = {b: _stiffer(part, factors.get(b, 1.0)) for b, part in numbers.constant.items()}
    return replace(numbers, constant=constant)


def _stiffer(part: ConstantNumbers, factor: float) -> ConstantNumbers:
    strains = part.strains._replace(weight=factor * part.strains.weight)
    return part._replace(stiffness=factor * part.stiffness, strains=strains)
