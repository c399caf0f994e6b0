"""A compiled scene at other numbers: pattern, elimination order, numbering and functions stay; what the numbers touch is made anew."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from toolkit.components.bodies.body import ConstantNumbers
from toolkit.components.joints.joint import keeps_rows
from toolkit.description.design import Design
from toolkit.scene.resolution import ResolvedScene, resolve
from toolkit.scene.scene import Scene
from toolkit.system.dependence import GROUPS, Affected
from toolkit.system.numbering import weights
from toolkit.system.pattern import NewEntryError, renew
from toolkit.system.plan import Kept, build_plan
from toolkit.system.quantities import OPEN, Quantities, check_numbers, renewed_derivatives, seen_quantities
from toolkit.system.solution import deforming
from toolkit.system.system import System, compile_scene


def renewed(system: System, scene: Scene, paths: list[str]) -> System:
    """System of a scene that differs from a compiled one in the numbers at some paths, and in nothing else.

    Whatever `compile_scene` would make of it gives the same results to round-off: an entry that has become zero stays in the pattern. A
    number that is not zero any more where nothing was before brings a new pattern, and the scene is compiled as if for the first time; so
    is one whose redundant joints are left out, because other numbers may make other ones redundant, and one whose profile of a cam falls
    into other pieces, or a point of which comes to lie between other nodes of a reduced part.

    Parameters
    ----------
    system
        The compiled scene at its old numbers.
    scene
        The scene at its new ones.
    paths
        Where they differ.

    Raises
    ------
    InputError
        As `compile_scene`.
    """
    scene = resolve(scene, system.scene)
    paths = [path for path in paths if path.split(".")[0] in GROUPS]
    if not paths:  # numbers of the solver and of responses stand in the scene alone
        return replace(system, scene=scene, origin=system.origin or system)
    names = list(system.design.names)
    if scene.cuts != system.scene.cuts:
        return compile_scene(scene, names, system.numbering.seen)
    if not system.compiled or scene.solver.redundant == "least-squares":
        return compile_scene(scene, names, system.numbering.seen)
    check_numbers(scene)
    numbering = system.numbering
    affected = _stirred(system, scene, numbering.affected_by(scene, paths))
    new, seen = seen_quantities(scene, numbering, affected, OPEN)
    asks_alike = all(system.asked[owner] == asked for owner, asked in seen.asked_by_components.items())
    joints = list(scene.joints.values())
    if not asks_alike or not all(keeps_rows(joints[j], scene, numbering.forms.rows[j]) for j in new.joints):
        return compile_scene(scene, names, numbering.seen)
    rates = renewed_derivatives(scene, numbering, system.design, system.derivatives, affected)
    changed: set[str] = set()
    try:
        values, *changes = (
            renew(before, after, system.values, changed)
            for before, after in zip([system.values, *system.derivatives], [new, *rates], strict=True)
        )
    except NewEntryError:
        return compile_scene(scene, names, numbering.seen)
    moved = any(group in ("points", "bodies") for group, _ in affected.items)
    sizes = weights(scene, numbering) if moved else system.weights
    if not np.array_equal(sizes, system.weights):
        changed.add("constant")
    plan = build_plan(scene, numbering, values, changes, float, sizes, Kept(system.plan, frozenset(changed)))
    design = Design(tuple(replace(each, value=scene.value_at(each.paths[0]) / each.factors[0]) for each in system.design))
    return replace(
        system, scene=scene, design=design, plan=plan, values=values, derivatives=changes, weights=sizes, origin=system.origin or system,
        known_curves={} if "curves" in changed else system.known_curves,
    )  # fmt: skip


def _stirred(system: System, scene: ResolvedScene, affected: Affected) -> Affected:
    """Items that may change, without joints that are written as they were and ask the scene for nothing.

    Most joints only name points and bodies.
    """
    before = system.scene.joints
    same = {
        ("joints", name)
        for j, (name, joint) in enumerate(scene.joints.items())
        if joint is before[name] and not system.asked["joints", j]
    }
    return Affected(affected.items - same, affected.markers)


def softened(system: System, factors: Mapping[str, float]) -> System:
    """A system whose bodies, or their parts, have given multiples of their stiffness.

    Only the stiffness changes, so that forces and masses are the same.

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
