"""What a long command says while it works, on standard error: a progress bar, and a note before code is compiled.

A run of the smallest scene there is, so that all that an analysis calls is compiled before it begins.

What is compiled depends on the dimension of space and on the analysis, but on no number of the scene; the formulas of its own kinds of
joints and loads come apart.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import typer
from rich.console import Console

from toolkit.bodies.rigid import Rod, SpatialRod
from toolkit.description.design import Point
from toolkit.description.run_options import Formulation, RunOptions
from toolkit.foundation.kernel import first_class
from toolkit.joints.kernels.laws import SIGNATURE as LAW_SIGNATURE
from toolkit.joints.kernels.laws import teeth_law, turn_law
from toolkit.joints.revolute import Revolute, SpatialRevolute
from toolkit.loads.gravity import Gravity, SpatialGravity
from toolkit.loads.kernels.load_kernel import SIGNATURE as LOAD_SIGNATURE
from toolkit.loads.load import Load
from toolkit.loads.springs import SpatialRotationalSpringDamper
from toolkit.responses.joint_force import JointForce
from toolkit.responses.motion import Displacement
from toolkit.scene.resolution import loaded
from toolkit.scene.scene import Scene
from toolkit.scene.space import PLANE, SPACE, Space
from toolkit.sensitivity.adjoint import adjoint_gradients, has_adjoint
from toolkit.sensitivity.errors.excited_vibrations import lost_parts
from toolkit.sensitivity.preparation import Kind, evaluate_responses, prepare, solve
from toolkit.system.evaluation import formulas_of
from toolkit.validity.energy_balance import energy_balance
from toolkit.validity.judge import judge

if TYPE_CHECKING:
    from toolkit.foundation.compiled.compile_watch import CompileWatch


def rehearse(scene: Scene, kind: Kind, backwards: bool = False) -> None:
    """Call everything compiled that an analysis of the scene calls, with `backwards` its adjoint too."""
    formulas_of(loaded(scene))
    small = pendulum_like(scene)
    system = prepare(small, ["points.P.x"] if backwards else [])
    solution = solve(system, kind)
    evaluate_responses(solution)
    judge(solution)
    if len(solution.times) > 1:
        energy_balance(solution)  # a verdict asks for these where there are more steps than one
        lost_parts(solution, None, 0.0, np.ones(1), np.zeros(1))
    if backwards and has_adjoint(small, kind):
        adjoint_gradients(system, solution)


def rehearse_others(scene: Scene) -> None:
    """Call everything compiled that any analysis of such a scene calls: all formulations of joints share their code, but for the adjoint,
    which one of them lacks."""
    options = scene.solver.model_copy(update={"formulation": "index-1"})
    rehearse(scene.model_copy(update={"solver": options}), "transient", backwards=True)


def rehearse_everything(space: Space) -> None:
    """Call everything compiled that scenes of built-in kinds call in the plane or in space, and compile the formulas of these kinds."""
    scene = _small(space, "index-1", forced=True, coiled=True)
    rehearse(scene, "static")
    rehearse_others(scene)
    for law in (turn_law, teeth_law):
        first_class(law, LAW_SIGNATURE)
    for kind in space.kinds["loads"].values():
        if issubclass(kind, Load):
            first_class(kind.law(), LOAD_SIGNATURE)


def pendulum_like(scene: Scene) -> Scene:
    """Hanging rod of the scene's dimension and formulation for one step, with what else of the scene has code of its own."""
    judged = [*scene.responses.values(), *(getattr(each, "of", None) for each in scene.responses.values())]
    forced = any(isinstance(each, JointForce) for each in judged)
    coiled = any(isinstance(load, Load) and load.turn for load in scene.loads.values())
    return _small(scene.space, scene.solver.formulation, forced, coiled)


def _small(space: Space, formulation: Formulation, forced: bool, coiled: bool) -> Scene:
    """Smallest scene, a hanging rod; on request with its joint's force as a response, and with a spring whose turns count."""
    options = RunOptions(end_time=1e-3, step=1e-3, formulation=formulation, load_steps=1)
    force = {"force": JointForce(joint="hinge", component="x")} if forced else {}
    common: dict[str, Any] = {
        "units": "m-kg-s",
        "responses": {"way": Displacement(body="rod", point="P", component="x"), **force},
    }
    return Scene(**common, **_PENDULUMS[space](coiled), solver=options)


ENDS: dict[str, Any] = {"between": ("O", "P"), "area": 1e-4, "density": 7800.0}
"""Fields of the rod of the smallest scene."""


def _planar(_coiled: bool) -> dict[str, Any]:
    return {
        "points": {"O": Point(x=0.0, y=0.0), "P": Point(x=0.0, y=-1.0)},
        "bodies": {"rod": Rod(**ENDS)},
        "joints": {"hinge": Revolute(bodies=("rod", "ground"), point="O")},
        "loads": {"weight": Gravity(acceleration=(0.0, -9.81))},
    }


def _spatial(coiled: bool) -> dict[str, Any]:
    """Fields of the smallest spatial scene; on request with a rotational spring, whose turns compiled code counts."""
    spring = SpatialRotationalSpringDamper(bodies=("rod", "ground"), point="O", axis=(0.0, 1.0, 0.0), stiffness=1.0)
    return {
        "dimension": 3,
        "points": {"O": Point(x=0.0, y=0.0, z=0.0), "P": Point(x=0.0, y=0.0, z=-1.0)},
        "bodies": {"rod": SpatialRod(**ENDS)},
        "joints": {"hinge": SpatialRevolute(bodies=("rod", "ground"), point="O", axis=(0.0, 1.0, 0.0))},
        "loads": {"weight": SpatialGravity(acceleration=(0.0, 0.0, -9.81)), **({"coil": spring} if coiled else {})},
    }


_PENDULUMS = {PLANE: _planar, SPACE: _spatial}


AnnouncedKind = Literal["transient", "static"]
Progress = Callable[[int, int], None]
BACKWARDS = ("auto", "adjoint")
"""Methods that may run backwards."""


@contextmanager
def at_work(
    title: str, scene: Scene, kind: AnnouncedKind, design: Sequence[str] = (), quiet: bool = False, method: str = "direct"
) -> Iterator[Progress]:
    """Show a bar that moves with the calls (done, in all) of the function given back; it vanishes at the end.

    All that the analysis of the scene calls is compiled before, if it never was on this machine, and it is said so; `method` is that of
    gradients by the variables in `design`.
    """
    from toolkit.foundation.compiled.compiled_code import CompiledCodeWarning

    with warnings.catch_warnings():
        if quiet:
            warnings.simplefilter("ignore", CompiledCodeWarning)
        compile_before(scene, kind, bool(design) and kind == "transient" and method in BACKWARDS, quiet)
        with bar(title, quiet) as progress:
            yield progress


def compile_before(scene: Scene, kind: AnnouncedKind, backwards: bool = False, quiet: bool = False) -> None:
    """Rehearse an analysis, so that nothing is compiled in it.

    If that compiles anything, say so, show how far it has come, and compile what other analyses call too, so that no later command has to.
    """

    with told_compilation(scene.dimension, quiet) as watch:
        rehearse(scene, kind, backwards)
        if watch.functions:
            rehearse_others(scene)


@contextmanager
def told_compilation(dimension: int, quiet: bool = False) -> Iterator[CompileWatch]:
    """Report compilation within this block, with its progress and, at the end, what was compiled."""
    from toolkit.foundation.compiled.compile_watch import watched_compilation
    from toolkit.foundation.compiled.compiled_code import is_kept

    functions, seconds = EXPECTED[dimension]
    with ExitStack() as shown:
        moves: list[Progress] = []

        def announce() -> None:
            if not quiet:
                typer.echo(
                    f"compiling the formulas for this machine, once for all commands: at most some {functions} functions, some "
                    f"{seconds} s of a free core ...",
                    err=True,
                )
            moves.append(shown.enter_context(bar("functions compiled", quiet)))

        with watched_compilation(announce, lambda done: moves[0](done, max(done, functions))) as watch:
            yield watch
    if watch.functions and not quiet:
        kept = "; they are kept on the disk" if is_kept() else ""  # elsewhere a warning has said what becomes of them
        typer.echo(f"{watch.functions} functions compiled in {watch.seconds:.0f} s{kept}.", err=True)


EXPECTED = {2: (220, 26), 3: (270, 38)}
"""Largest numbers of functions compiled, and of seconds it takes, by the dimension of space.

Measured by `python -m tests.benchmarks.first_run`, in processor time of a free core, which of a busy one is two fifths more: in the plane
212 functions in 20 s for a motion in any formulation, which an equilibrium shares, and 14 in 2 s for its adjoint; in space 261 in 30 s, and
13 in 2 s. Formulas of kinds of joints and loads come apart."""


@contextmanager
def bar(title: str, quiet: bool = False) -> Iterator[Progress]:
    """Progress bar on standard error with elapsed and remaining time, if that is a terminal and `quiet` is off."""
    console = Console(stderr=True)
    if quiet or not console.is_terminal:
        yield lambda _done, _total: None
        return
    from rich.progress import BarColumn, SpinnerColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn
    from rich.progress import Progress as Bar  # for terminals alone

    times = TimeElapsedColumn(), TextColumn("left:"), TimeRemainingColumn()
    columns = SpinnerColumn(), TextColumn("{task.description}"), BarColumn(), *times
    with Bar(*columns, console=console, transient=True) as shown:
        task = shown.add_task(title, total=None)
        yield lambda done, total: shown.update(task, completed=done, total=total)
