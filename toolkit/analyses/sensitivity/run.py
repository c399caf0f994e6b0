"""Run of a scene: values and gradients of its responses, the states behind them, whether to trust them, and ways to look at them."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np

from toolkit.analyses.sensitivity.errors.basis_errors import BasisErrors, Enriched, basis_errors, cautions_of_frozen
from toolkit.analyses.sensitivity.errors.lost_vibrations import lost_vibrations
from toolkit.analyses.sensitivity.errors.step_cautions import (
    Answers,
    step_cautions,
    turned_displacements,
    unfelt_variables,
    unless_it_converges,
    unless_unfelt,
    without_false_zeros,
)
from toolkit.analyses.sensitivity.errors.step_error import Repeat, StepError, step_error
from toolkit.analyses.sensitivity.gradient_errors import (
    NONE,
    AddedErrors,
    FrameErrors,
    Reframed,
    added_errors,
    bodies_with_more,
    cautions_of_added,
    doubtful_gradients,
    doubtful_values,
    frame_errors,
    framed_doubts,
    unless_frames_deny,
)
from toolkit.analyses.sensitivity.preparation import moving, prepare, responses_of, variable_sizes
from toolkit.description.results_layout import STATES, ResultsFileError
from toolkit.foundation.value_types import Record, Scalar
from toolkit.foundation.verdict import Caution, Verdict
from toolkit.responses.energy import Largest, largest_in, magnitude_that_counts
from toolkit.responses.extremes import at_peaks, changes_at_peaks, loose_maxima, missed_peaks, tied_extremes, tied_stresses
from toolkit.responses.flutter import growing_vibrations, unstable_vibrations
from toolkit.responses.relative_angle import folded_equilibria, folded_rotations
from toolkit.responses.vibration import Frequency
from toolkit.scene.scene import Scene
from toolkit.system.solution import Solution
from toolkit.validity.bodies.few_shapes import frozen_bodies
from toolkit.validity.bodies.frequencies import cautions_of_frequencies
from toolkit.validity.bodies.full_scene import cautions_of_changed
from toolkit.validity.bodies.merging_vibrations import merging_vibrations
from toolkit.validity.bodies.physics import critical_loads
from toolkit.validity.bodies.pulled_joints import steep_joints, tension
from toolkit.validity.bodies.sheared_beams import sheared_vibrations
from toolkit.validity.bodies.stiffened_bodies import most_pulled
from toolkit.validity.curve_checks import unseen_moves
from toolkit.validity.dead_points import dead_points_passed
from toolkit.validity.judge import cautions, measures
from toolkit.validity.motion import SUSPICIOUS_ENERGY_DEFECT, force_cautions

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from toolkit.files.results import Results
    from toolkit.files.tables import ShortTable
    from toolkit.validity.motion import Measures

UNIMPORTANT_EFFECT = 0.02
"""A derivative that changes its response by less than this part of its magnitude, where the variable changes by all of its size, is
compared with such a change instead of with itself."""


@dataclass(frozen=True)
class Run:
    """Motion or equilibrium of a scene: values of its responses, their gradients, and the states behind them.

    Nobody makes one by hand: `Model.simulate` and `Model.statics` return it, and `load` reads one back. `print(run)` shows a short table
    with the verdict, and a notebook shows the same.

    Attributes
    ----------
    values
        Response -> its value.
    units
        Response -> label of its unit.
    gradients
        Response -> variable -> derivative; empty if none were asked for.
    method
        How gradients were found: "direct", "adjoint", a numerical method, or "none".
    solution
        States at all times, and their derivatives if they were computed.
    wall_primal, wall_sensitivity
        Time of a run without gradients, and what these cost more, in s; None where nobody measured it, because that takes a run without
        gradients beside the one with them.
    reason
        Why the method was chosen, if nobody named one.
    repeat
        The same analysis with other options, which `verdict` needs.
    reframed
        The same analysis with other floating frames, which `verdict` needs where there are gradients.
    enriched
        The same analysis with more shapes in frozen bodies, which `verdict` needs away from their design and for gradients.
    verdict
        Whether the numbers can be trusted, with all reasons against it. It is found out when it is first asked for; that takes up to a few
        more runs with steps of other lengths.
    warnings
        The same as a tuple, doubts first.
    """

    values: dict[str, Any]
    units: dict[str, str]
    gradients: dict[str, dict[str, float]]
    method: str
    solution: Solution
    wall_primal: float | None
    wall_sensitivity: float | None
    reason: str = ""
    repeat: Repeat | None = field(default=None, compare=False)
    reframed: Reframed | None = field(default=None, compare=False)
    enriched: Enriched | None = field(default=None, compare=False)

    @cached_property
    def measures(self) -> Measures:
        """Measures of how exactly the states were found, see `toolkit.validity.judge.measures`."""
        return measures(self.solution)

    @cached_property
    def step_error(self) -> StepError | None:
        """Estimated time-step errors, measured by the same run with steps of another length when first asked for."""
        solution = self.solution
        if self.repeat is None or not moving(solution) or not self.values:
            return None
        suspicious = not max(self.measures["energy_balance"].values(), default=0.0) <= SUSPICIOUS_ENERGY_DEFECT
        known = self._answers
        responses = {name: each for name, each in responses_of(solution.system.scene).items() if name in self.values}
        lost = lost_vibrations(solution, responses, known.scales)
        changes = changes_at_peaks(solution) if self.gradients else {}
        return step_error(
            solution, self.values, self.gradients, known.scales, known.slope_scales, self.repeat, suspicious, lost, changes
        )

    @cached_property
    def _answers(self) -> Answers:
        """Values and gradients of a motion, and the scales of their errors."""
        solution = self.solution
        responses = responses_of(solution.system.scene)
        largest = {name: largest_in(each, solution, self.values[name]) for name, each in responses.items()}
        scales = {name: magnitude_that_counts(each, solution, largest[name]) for name, each in responses.items()}
        return Answers(self.values, self.gradients, scales, self._slope_scales(scales, largest))

    def _slope_scales(self, scales: dict[str, float], found: dict[str, Largest]) -> dict[str, dict[str, float]]:
        """Scales of errors of derivatives: the largest in the motion, or a small effect of all of the variable."""
        scene, solution = self.solution.system.scene, self.solution
        sizes, counting = variable_sizes(scene, self) if self.gradients else {}, {}
        for f in found if sizes else ():
            largest = dict(zip(solution.system.design.names, found[f].slopes, strict=True))
            counting[f] = {
                x: max(largest.get(x, 0.0), UNIMPORTANT_EFFECT * scales[f] / size if size else 0.0) for x, size in sizes.items()
            }
        return counting

    @cached_property
    def frame_errors(self) -> FrameErrors | None:
        """Estimated errors by the number of floating frames, by a run with more of them when first asked for."""
        if self.reframed is None or not self.gradients:
            return None
        return self._frame_errors()

    def _frame_errors(self, doubted: Collection[str] = ()) -> FrameErrors | None:
        assert self.reframed is not None
        known = self.values, at_peaks(self.gradients, self.solution), self.scales
        return frame_errors(self.solution, *known, self.reframed, doubted, self.basis_errors)

    @cached_property
    def basis_errors(self) -> BasisErrors | None:
        """Errors by frozen bases, by the same analysis with more shapes when first asked for; None without frozen bases."""
        if self.enriched is None or not self.values:
            return None
        scene, variables = self.solution.system.scene, next(iter(self.gradients.values()), {})
        bodies = frozen_bodies(scene, variables)
        if not bodies:
            return None
        scales, slopes = self._answers[2:] if moving(self.solution) else (self._undecided, {})
        return basis_errors(
            bodies,
            {f: (value, scales[f]) for f, value in self.values.items()},
            {f: {x: (slope, slopes[f][x] if slopes else 0.0) for x, slope in row.items()} for f, row in self.gradients.items()},
            variable_sizes(scene, self) if variables else {},
            self.enriched,
        )

    @property
    def gradient_scales(self) -> Mapping[str, Mapping[str, float]]:
        """Response -> variable -> the largest gradient in the motion, which errors of gradients are compared with; empty in statics."""
        return self._answers.slope_scales if moving(self.solution) else {}

    @property
    def _undecided(self) -> dict[str, float]:
        """Uncertainty that Newton's method leaves in the values of a state at rest, by response."""
        responses = responses_of(self.solution.system.scene, moving=False)
        return {f: magnitude_that_counts(each, self.solution, NONE) for f, each in responses.items()}

    @cached_property
    def verdict(self) -> Verdict:
        """Whether values and gradients can be trusted, and why not; found when first asked for.

        That costs half a run, one with more floating frames where there are gradients of bodies that deform far, and one with
        more shapes where bases are frozen.
        """
        self.solution.system.refuse_changed_files()
        found, errors = self._verdict, self.weighed_frames
        if self.gradients and self.solution.system.n_x and (errors is None or most_pulled(self.solution) not in errors.frames):
            found = Verdict.of([*found.warnings, *steep_joints(self.solution)], found.measures)
        if self.basis_errors is not None:
            about_bases = {**found.measures, "frozen_basis": self.basis_errors.record()}
            found = Verdict.of([*found.warnings, *cautions_of_frozen(self.basis_errors)], about_bases)
        if errors is None:
            return found
        sizes = variable_sizes(self.solution.system.scene, self)
        scales, slopes = self.scales, self.gradient_scales
        weighed = unless_frames_deny(found.warnings, self.solution, errors, scales, self.gradients, sizes, slopes)
        doubts = (
            *doubtful_values(errors, scales),
            *doubtful_gradients(errors, self.gradients, sizes, slopes),
            *cautions_of_added(*self.added_errors),
        )
        record = errors.record(self.gradients, sizes, slopes)
        return Verdict.of([*weighed, *doubts], {**found.measures, "geometric_error": record})

    @property
    def added_errors(self) -> tuple[dict[str, AddedErrors], dict[str, AddedErrors]]:
        """Errors by steps and by frames, of values and of gradients, as far as both are known of a motion."""
        sizes = variable_sizes(self.solution.system.scene, self) if self.gradients else {}
        return added_errors(self.weighed_frames, self.step_error, self.scales, self.gradients, sizes, self.gradient_scales)

    @property
    def scales(self) -> Mapping[str, float]:
        """Response -> the largest value in a motion, which errors by frames are compared with; without a motion its value."""
        return self._answers.scales if moving(self.solution) else {f: abs(value) for f, value in self.values.items()}

    @cached_property
    def weighed_frames(self) -> FrameErrors | None:
        """Errors by the number of frames, with bodies that are doubted among those that are given more."""
        bodies = framed_doubts(self._verdict.warnings)
        if self.reframed is None or not self.gradients or bodies <= set(bodies_with_more(self.solution)):
            return self.frame_errors
        return self._frame_errors(bodies)

    @cached_property
    def _verdict(self) -> Verdict:
        """The verdict without the effects of frames and frozen bases on gradients."""
        if self.repeat is None or not moving(self.solution) or not self.values:
            found = self.solution.verdict
            folded = folded_equilibria(self.solution) if self.values and not self.solution.steps else ()
            loose = loose_maxima(self.solution) if self.values else ()
            of_state = set(unstable_vibrations(self.solution))  # said again by what was asked for
            others = [each for each in found.warnings if each not in of_state]
            tied = tied_stresses(self.solution) if self.gradients else ()
            every = [*others, *self._of_vibrations(), *folded, *loose, *tied, *self._undefined()]
            return Verdict.of(without_false_zeros(every), found.measures)
        measured: Measures = {**self.measures}
        options = self.solution.options or self.solution.system.scene.solver
        about_steps = step_cautions(self.step_error, self.values, self.gradients, options)
        if self.step_error is not None:
            estimated: Record = {
                "how": self.step_error.how,
                "relative_to": "the largest magnitude in the motion",
                "responses": self.step_error.values,
                "gradients": self.step_error.gradients,
            }
            measured["estimated_error"] = {**measured["estimated_error"], **estimated}
        about_forces = force_cautions(self.solution, measured["force_noise"], self._answers.scales)
        variables = next(iter(self.gradients.values()), {})
        about_responses = (
            *about_forces,
            *about_steps,
            *unseen_moves(self.solution, variables),
            *dead_points_passed(self.solution, variables),
            *folded_rotations(self.solution),
            *missed_peaks(self.solution),
            *turned_displacements(self.solution, self.values, self._answers.scales),
            *loose_maxima(self.solution),
            *tied_extremes(self.solution),
            *tied_stresses(self.solution),
            *self._undefined(),
            *self._of_vibrations(),
        )
        about_states = unless_it_converges(cautions(self.solution), self.solution, self.step_error, self.measures)
        about_states = unless_unfelt(about_states, self.solution, self._answers)
        return Verdict.of(without_false_zeros([*about_states, *about_responses]), measured)

    @property
    def warnings(self) -> tuple[Caution, ...]:
        """All cautions of the verdict, doubts first."""
        return self.verdict.warnings

    def _of_vibrations(self) -> Iterator[Caution]:
        """Cautions about vibrations that too long elements or left-out shapes change, or that are stiffened or grow."""
        scene = self.solution.system.scene
        responses = {f: each for f, each in scene.responses.items() if f in self.values}
        asked = {f: self.values[f] for f, each in responses.items() if isinstance(each, Frequency)}
        yield from cautions_of_frequencies(self.solution, asked, doubt=True, differentiated=bool(self.gradients))
        yield from sheared_vibrations(self.solution, asked, bool(self.gradients))
        yield from cautions_of_changed(self.solution)
        yield from growing_vibrations(self.solution, self.values)
        if self.gradients and not self.solution.system.n_x:
            yield from critical_loads(self.solution, lateral=True)  # what its derivatives feel is not known
            yield from tension(self.solution, lateral=True)
            yield from merging_vibrations(self.solution, lateral=True)

    def _undefined(self) -> Iterator[Caution]:
        """Remarks on values and derivatives that do not exist at this design, and on variables that nothing feels."""
        yield from unfelt_variables(self.gradients)
        numbers = {f"the value of {name}": value for name, value in self.values.items()}
        numbers |= {f"the derivative of {f} by {x}": slope for f, slopes in self.gradients.items() for x, slope in slopes.items()}
        for what, number in numbers.items():
            if not np.isfinite(number):
                yield Caution("undefined", f"{what} does not exist at this design; it is nan, in JSON null.", doubt=False)

    def __reduce__(self) -> NoReturn:
        raise TypeError(
            "a run cannot be pickled: keep it with run.save(path), or hand out run.values, run.gradients, run.verdict"
        )

    @property
    def scene(self) -> Scene:
        """Scene that was run, at the numbers of the run."""
        return self.solution.system.scene

    def table(self) -> str:
        """Values, gradients and the verdict as lines of text.

        Returns
        -------
        text
            One line for every response, one for every gradient, and the verdict with its reasons.
        """
        return "\n\n".join([*(table.text() for table in self._tables()), str(self.verdict)])

    def stress(self, body: str) -> tuple[np.ndarray, np.ndarray]:
        """Stress of a flexible body at all its stress points and all times, with its derivatives.

        Parameters
        ----------
        body
            Name of the body.

        Returns
        -------
        stress
            (n_times, n_points), in the scene's unit of stress; of solids in space that of von Mises.
        dstress
            (n_times, n_points, n_variables), total derivatives by the model's variables; none if the run did not compute them.

        Raises
        ------
        InputError
            There is no flexible body of that name; or the file of its reduced model has changed since the scene was compiled.
        ModelFileError
            Its reduced model holds no stress.
        """
        from toolkit.responses.stress import stress_field

        self.solution.system.scene.body(body)
        self.solution.system.refuse_changed_files()
        return stress_field(self.solution, body)

    def plot(self) -> Figure:
        """Curves of a motion over time, or an equilibrium as a picture.

        Returns
        -------
        figure
            A figure of matplotlib, which a notebook shows; `figure.savefig("run.svg")` keeps it.

        Raises
        ------
        RenderError
            matplotlib is not installed; or the run is an equilibrium in space, which `render` draws.
        """
        from toolkit.render.pictures import figure_of

        self.solution.system.refuse_changed_files()
        return figure_of(self.solution)

    def render(
        self, directory: str | Path = "output", instants: Sequence[float] | None = None, width: int = 1600, format: str = "png"
    ) -> list[Path]:
        """Draw the scene at several instants into the files of a folder.

        Parameters
        ----------
        directory
            Folder of the pictures, which is made if it does not exist.
        instants
            Times; each is drawn at the nearest step. By default up to four at which something happens.
        width
            Of every picture, in pixels.
        format
            "png"; of scenes in the plane also "svg" or "pdf".

        Returns
        -------
        files
            Paths of the pictures.

        Raises
        ------
        RenderError
            A package or a system library is missing; names what to install.
        InputError
            An instant lies outside of the run, or there are no such files.
        """
        from toolkit.render.pictures import render_solution
        from toolkit.render.readable_units import View

        self.solution.system.refuse_changed_files()
        return render_solution(self.solution, directory, instants, width, View(format=format))

    def save(self, path: str | Path) -> Path:
        """Keep states, stress, values, gradients, verdict and scene in a file, which `load`, `ffrf render` and `ffrf export` read.

        Parameters
        ----------
        path
            Name of the file, by custom ending in .h5. An older results file of that name is replaced as a whole.

        Returns
        -------
        path
            Of the file.

        Raises
        ------
        InputError
            There is a file of that name that is no results file, or the folder cannot be written to.
        """
        from toolkit.files.results_file import save_results

        self.solution.system.refuse_changed_files()
        save_results(self, Path(path))
        return Path(path)

    def __str__(self) -> str:
        return self.table()

    def __repr__(self) -> str:
        kind = "motion" if moving(self.solution) else "equilibrium"
        values = ", ".join(f"{name} = {value:.6g} {self.units[name]}".rstrip() for name, value in self.values.items())
        return f"<Run: {kind}, {values or 'no responses'}; method {self.method}>"

    def _repr_html_(self) -> str:
        """HTML that a notebook shows."""
        return "".join(table.html() for table in self._tables()) + f"<pre>{escape(str(self.verdict))}</pre>"

    def _tables(self) -> list[ShortTable]:
        from toolkit.files.tables import table_of_gradients, table_of_values

        return [table for table in (table_of_values(self), table_of_gradients(self)) if table is not None]


def run_of(
    solution: Solution,
    values: Mapping[str, Scalar],
    gradients: dict[str, dict[str, float]],
    method: str,
    primal: float | None,
    extra: float | None,
    repeat: Repeat | None = None,
) -> Run:
    """Run with the units of its responses; arguments as the fields of `Run`."""
    scene = solution.system.scene
    units = {name: response.unit(scene.units) for name, response in responses_of(scene, moving(solution)).items()}
    real = {name: float(np.real(value)) for name, value in values.items()}
    return Run(real, units, gradients, method, solution, primal, extra, repeat=repeat)


def load(path: str | Path, models: str | Path | None = None) -> Run:
    """Read a run that `Run.save` or `ffrf ... --output` has kept, without solving anything.

    Parameters
    ----------
    path
        The results file.
    models
        Folder of the reduced models, if they are not where they were.

    Returns
    -------
    run
        Values, gradients, states and verdict as they were kept.

    Raises
    ------
    ResultsFileError
        The file cannot be read, or a reduced model is missing or another one.
    """
    from toolkit.files.results_file import load_results

    return restored(load_results(Path(path)), models)


def restored(results: Results, models: str | Path | None = None) -> Run:
    """Run whose results were kept, with its scene compiled as if it had just been solved; arguments and errors as of `load`."""
    from toolkit.files.results import restore_scene

    system = prepare(restore_scene(results, models), results.design)
    n_q, names = system.n_q, list(system.numbering.names)
    if (names[:n_q], names[n_q:]) != (results.coordinates, results.multiplier_names):
        raise ResultsFileError(
            f"the scene in {results.label} has other unknowns than its states; the file is damaged, or this program numbers them "
            "in another way. Run the scene again."
        )
    states, counted = {name: getattr(results, name) for name in STATES}, dict(results.run)
    primal, extra = (counted.pop(name) for name in ("wall_primal", "wall_sensitivity"))
    solution = Solution(system, **states, **counted, judge=lambda _: results.verdict)
    return Run(results.responses, results.response_units, results.gradients, results.method, solution, primal, extra)
