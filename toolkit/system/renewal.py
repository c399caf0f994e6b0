"""A compiled scene at other numbers: pattern, elimination order, numbering and functions stay; what the numbers touch is made anew."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from toolkit.compilation.checks import check_numbers
from toolkit.compilation.dependence import GROUPS
from toolkit.compilation.numbering import weights
from toolkit.compilation.patterns.kept_pattern import NewEntryError, renew
from toolkit.compilation.plan import Kept, build_plan
from toolkit.compilation.quantities import derivatives, seen_quantities
from toolkit.compilation.remembered import Remembered
from toolkit.description.design import Design
from toolkit.joints.row_checks import keeps_rows
from toolkit.scene.cut_scene import parts_of, with_parts
from toolkit.scene.scene import Scene
from toolkit.system.system import System, compile_scene


def renewed(system: System, scene: Scene, paths: list[str]) -> System:
    """The system of a scene that differs from a compiled one in the numbers at some paths, and in nothing else.

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
    scene = with_parts(scene)
    paths = [path for path in paths if path.split(".")[0] in GROUPS]
    if not paths:  # numbers of the solver and of responses stand in the scene alone
        return replace(system, scene=scene).compiled_as(system)
    names = list(system.design.names)
    if parts_of(scene) != parts_of(system.scene):
        return compile_scene(scene, names, system.numbering.seen)
    if not system.compiled or scene.solver.redundant == "least-squares":
        return compile_scene(scene, names, system.numbering.seen)
    placed = Remembered(scene, system.placed)
    check_numbers(scene, placed)
    numbering = system.numbering
    affected = numbering.affected_by(scene, paths)
    new, seen = seen_quantities(scene, numbering, affected, placed)
    if not all(keeps_rows(part.written[0], placed, numbering.forms.rows[j]) for j, part in seen.parts["joints"].items()):  # type: ignore[arg-type]
        return compile_scene(scene, names, numbering.seen)
    rates = derivatives(scene, numbering, system.design, seen, affected)
    try:
        pairs = [renew(system.values, new, system.values)]
        for before, after in zip(system.derivatives, rates, strict=True):
            pairs.append(renew(before, after.rates, system.values, after.still))
    except NewEntryError:
        return compile_scene(scene, names, numbering.seen)
    (values, *changes), changed = [found for found, _ in pairs], frozenset().union(*(groups for _, groups in pairs))
    moved = any(group in ("points", "bodies") for group, _ in affected.items)
    sizes = weights(scene, placed) if moved else system.weights
    changed |= frozenset() if np.array_equal(sizes, system.weights) else {"constant"}
    plan = build_plan(scene, numbering, values, changes, float, sizes, Kept(system.plan, changed))
    design = Design(tuple(replace(each, value=scene.value_of(each.name)) for each in system.design))
    found = replace(system, scene=scene, design=design, plan=plan, values=values, derivatives=changes, weights=sizes)
    found.__dict__.update(placed=placed)
    return found.compiled_as(system)
