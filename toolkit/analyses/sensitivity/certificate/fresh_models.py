"""Gradients end to end: those of the stored derivatives against differences of reduced models that are built afresh.

A parameter of a reduced model is changed where it stands, in the skin file beside the model, and everything is done again: splines,
gmsh, elements, basis, invariants, simulation. With f(x) from fresh models and c(h) = [f(x + h) - f(x - h)] / 2h

    df/dx = [4 c(h/2) - c(h)] / 3,    uncertain by |c(h/2) - c(h)| + 3 eps |f| / h

The second term is what round-off of the four values, eps |f| each, makes of the combination at most.
"""

from __future__ import annotations

import json
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from toolkit.analyses.sensitivity.errors.basis_errors import UNIMPORTANT
from toolkit.analyses.sensitivity.preparation import Kind, typical_size, values_of, variable_sizes
from toolkit.analyses.sensitivity.run import Run
from toolkit.components.bodies.model_body import ModelBody
from toolkit.description.description import Scalar
from toolkit.description.design import BodyPoint, DesignVariable
from toolkit.foundation.errors import InputError
from toolkit.foundation.processes import run
from toolkit.foundation.value_types import Record
from toolkit.foundation.verdict import Caution
from toolkit.reduced_model.model import ReducedModel
from toolkit.responses.stress import model_parameter
from toolkit.scene.resolution import loaded
from toolkit.scene.scene import Scene
from toolkit.validity.bodies.deformation import LIMIT

PROGRAM = "preprocessing.commands.designs_command"


def source(scene: Scene, body: str) -> Path:
    """The skin file that a body's model would be built from; it may not exist."""
    flexible: Any = scene.bodies[body]
    return (scene.directory / flexible.model).with_suffix(".toml")


def rebuildable(scene: Scene) -> dict[str, Path]:
    """Flexible body -> its skin file, where there is one."""
    found = {name: source(scene, name) for name, body in scene.bodies.items() if isinstance(body, ModelBody)}
    return {name: path for name, path in found.items() if path.is_file() and is_built_from(scene, name, path)}


def is_built_from(scene: Scene, body: str, skin: Path) -> bool:
    """Whether a body's model was built from a file of that name, and not one of another purpose lies beside it."""
    flexible: Any = scene.bodies[body]
    return skin.name in {Path(name).name for name in scene.model(flexible.model).inputs}


def given_values(scene: Scene, body: str) -> dict[str, Scalar]:
    """Parameters to which the scene gives values of its own, by their names for the preprocessing."""
    flexible: Any = scene.bodies[body]
    places = {f"interface_points.{name}.arc_length": s for name, s in loaded(scene).arc_lengths(flexible).items()}
    return {**flexible.model_values(), **places}


def with_model(scene: Scene, body: str, file: Path) -> Scene:
    """The scene with another reduced model of a body, and nothing given that is in the model already."""
    flexible: Any = scene.bodies[body]
    plain = type(flexible)(**{key: value for key, value in flexible if key in type(flexible).model_fields} | {"model": str(file)})
    points = {
        name: point.model_copy(update={"arc_length": None}) if isinstance(point, BodyPoint) and point.body == body else point
        for name, point in scene.points.items()
    }
    return scene.model_copy(update={"bodies": {**scene.bodies, body: plain}, "points": points})


def build_all(skin: Path, wanted: Sequence[Mapping[str, object]]) -> list[Record]:
    """Reduced models of one skin file in one process of the preprocessing.

    Parameters
    ----------
    wanted : tables {"file": where it goes, "values": {parameter: value}, "keys": {key of skin.toml: value}}, the last two optional

    Returns
    -------
    built : list
        Tables {"file": ..., "tables": the tables of skin.toml that other keys changed}.

    Raises
    ------
    InputError
        The preprocessing is not installed, or refuses one of them.
    """
    done = run(PROGRAM, [str(skin)], "\n".join(map(json.dumps, wanted)))
    if done.returncode:
        raise InputError(f"preprocessing afresh failed: {done.stderr.strip()}")
    return [json.loads(line) for line in done.stdout.splitlines()]


RELATIVE_STEP = 1e-3
"""Errors of fourth order are 1e-12 of a smooth response, and the round-off of fresh eigenmodes is magnified to 1.5e-6 at most."""
TOLERANCE = 1e-5
"""Relative difference of a derivative of a smooth response that no round-off explains."""
ROUND_OFF = 5e-10
"""Relative changes eps of a response by the round-off of fresh shapes: the stress of a solid differs by 4e-10 between processors."""
FROZEN = "the basis is frozen, so that a fresh one differs: this is the error of freezing it"


STEPS = (1.0, -1.0, 0.5, -0.5)
"""Displacements of the four difference points, in units of a variable's step."""


class FreshPart(NamedTuple):
    """A parameter of a reduced model that a variable drives."""

    body: str
    parameter: str  # its name for the preprocessing
    value: float
    factor: float


class WantedBodies(NamedTuple):
    """A variable of which fresh models are wanted."""

    variable: DesignVariable
    parts: list[FreshPart]
    rest: DesignVariable | None  # the same without the numbers that are in models
    step: float

    @property
    def bodies(self) -> list[str]:
        """Names of the bodies whose models are built afresh."""
        return list(dict.fromkeys(part.body for part in self.parts))


class Fresh(NamedTuple):
    """A derivative by fresh models, and the difference between the difference quotients as its uncertainty."""

    slope: float
    uncertainty: float


@dataclass(frozen=True)
class FreshGradients:
    """Derivatives by fresh models, response -> variable -> derivative; the variables without them, and those of frozen bases."""

    slopes: dict[str, dict[str, Fresh]] = field(default_factory=dict)
    left_out: dict[str, str] = field(default_factory=dict)
    frozen: dict[str, str] = field(default_factory=dict)  # variable -> what its difference means


def disagreements(found: FreshGradients, exact: Run) -> Iterator[str]:
    """Sentences on gradients that differ from those of fresh models by more than `TOLERANCE` and their uncertainty.

    Gradients of a frozen basis are left out: that they differ is what freezing means, see `doubts_of_fresh`.
    """
    for response, slopes in found.slopes.items():
        for variable, fresh in slopes.items():
            slope = exact.gradients[response][variable]
            if variable not in found.frozen and not abs(slope - fresh.slope) <= TOLERANCE * abs(slope) + fresh.uncertainty:
                yield (
                    f"d {response} / d {variable} is {slope:.10g} by the reduced model's derivatives, and {fresh.slope:.10g} by models "
                    "built afresh"
                )


def doubts_of_fresh(found: FreshGradients, exact: Run) -> Iterator[Caution]:
    """Doubts about gradients of frozen bases that differ too much from those of fresh models."""
    sizes, off = variable_sizes(exact.solution.system.scene, exact), []
    for response, slopes in found.slopes.items():
        most = max((abs(each.slope) * sizes[x] for x, each in slopes.items()), default=0.0)
        for x, each in slopes.items():
            slope = exact.gradients[response][x]
            error = max(abs(slope - each.slope) - each.uncertainty, 0.0)
            if x in found.frozen and error > LIMIT * abs(each.slope) and max(error, abs(slope)) * sizes[x] > UNIMPORTANT * most:
                off.append(f"d {response} / d {x} is {slope:.4g} and not about {each.slope:.4g}")
    if off:
        yield Caution(
            "fresh-models",
            f"gradients of frozen bases differ from those of models built afresh by more than {LIMIT:.0%}: {', '.join(off)}. Take "
            'derivative = "differentiated" in [basis], or more shapes.',
        )


def fresh_gradients(scene: Scene, design: list[str], kind: Kind, progress: Callable[[int, int], None]) -> FreshGradients:
    """Differences of fresh models for all design variables that are parameters of reduced models.

    Raises
    ------
    InputError
        The preprocessing is not installed, or refuses a skin file.
    """
    found, wanted = FreshGradients(), []
    for variable in scene.design_variables(design):
        each = _wanted(scene, variable)
        if each.parts and (reason := next(filter(None, (_hindrance(scene, part) for part in each.parts)), "")):
            found.left_out[variable.name] = reason
        elif each.parts:
            wanted.append(each)
            if any(_is_frozen(scene, body) for body in each.bodies):
                found.frozen[variable.name] = FROZEN
    with tempfile.TemporaryDirectory() as folder:
        _build(scene, wanted, Path(folder))
        for k, each in enumerate(wanted):
            for response, fresh in _differences(scene, k, each, Path(folder), kind).items():
                found.slopes.setdefault(response, {})[each.variable.name] = fresh
            progress(k + 1, len(wanted))
    return found


def _is_frozen(scene: Scene, name: str) -> bool:
    """Whether a body has shapes that stay the same when the design changes: those of its model, or of its reduced parts."""
    body: Any = scene.bodies[name]
    return _model(scene, name).basis.startswith("frozen") or getattr(body, "modes_per_frame", None) is not None


def _wanted(scene: Scene, variable: DesignVariable) -> WantedBodies:
    """Numbers of a variable, with those in reduced models apart."""
    parts, rest = [], []
    for path, factor in zip(variable.paths, variable.factors, strict=True):
        body, parameter = _parameter(scene, path)
        if body:
            parts.append(FreshPart(body, parameter, scene.value_at(path), factor))
        else:
            rest.append((path, factor))
    others = replace(variable, paths=tuple(p for p, _ in rest), factors=tuple(f for _, f in rest)) if rest else None
    return WantedBodies(variable, parts, others, RELATIVE_STEP * typical_size(scene, variable))


def _parameter(scene: Scene, path: str) -> tuple[str, str]:
    """Flexible body whose reduced model has the number among its parameters, and the parameter's name for the preprocessing."""
    for name, body in scene.bodies.items():
        if isinstance(body, ModelBody) and (parameter := model_parameter(scene, name, path)):
            if parameter in _model(scene, name).nominal and path.startswith("bodies."):
                return name, parameter
            if path.startswith("points."):
                return name, f"interface_points.{parameter.removeprefix('arc_length_')}.arc_length"
    return "", ""


def _hindrance(scene: Scene, part: FreshPart) -> str:
    """Reason why there are no fresh models of a parameter; empty if there are."""
    if scene.start_file is not None:
        return "the run starts in a results file (solver.start), which is that of the model as it is"
    skin = source(scene, part.body)
    if not skin.is_file():
        return f"there is no {skin.name} beside the reduced model to build it from"
    if not is_built_from(scene, part.body, skin):
        return f"the reduced model was not built from the {skin.name} beside it"
    if part.value == 0 and "damping" in part.parameter:
        return "damping is zero and cannot be less"
    return ""


def _differences(scene: Scene, k: int, wanted: WantedBodies, folder: Path, kind: Kind) -> dict[str, Fresh]:
    """Derivatives of all responses by variable k, from difference quotients of fresh models."""
    up, down, half_up, half_down = (values_of(_afresh(scene, k, i, wanted, folder), kind) for i in range(len(STEPS)))
    found = {}
    for name in up:
        coarse, fine = (up[name] - down[name]) / (2 * wanted.step), (half_up[name] - half_down[name]) / wanted.step
        noise = 3 * ROUND_OFF * abs(up[name]) / wanted.step
        found[name] = Fresh(float(np.real(4 * fine - coarse)) / 3, float(np.abs(fine - coarse) + noise))
    return found


def _afresh(scene: Scene, k: int, i: int, wanted: WantedBodies, folder: Path) -> Scene:
    """The scene with the models of variable k at step i, and all else that it drives moved with them."""
    for body in wanted.bodies:
        scene = with_model(scene, body, _file(folder, k, i, body))
    return scene if wanted.rest is None else scene.moved(wanted.rest, STEPS[i] * wanted.step)


def _file(folder: Path, k: int, i: int, body: str) -> Path:
    return folder / f"{k} {i} {body}.h5"


def _build(scene: Scene, wanted: list[WantedBodies], folder: Path) -> None:
    """Build all models of each body in one process: those of every variable at every step."""
    for body in dict.fromkeys(body for each in wanted for body in each.bodies):
        lines, given = [], given_values(scene, body)
        for k, each in enumerate(wanted):
            if body in each.bodies:
                mine = [part for part in each.parts if part.body == body]
                for i, s in enumerate(STEPS):
                    values = {**given, **{part.parameter: part.value + s * each.step * part.factor for part in mine}}
                    lines.append({"file": str(_file(folder, k, i, body)), "values": values})
        build_all(source(scene, body), lines)


def _model(scene: Scene, body: str) -> ReducedModel:
    flexible: Any = scene.bodies[body]
    return scene.model(flexible.model)
