"""What an analysis returns to a user: numbers, whether to trust them, and ways to look at them."""

from __future__ import annotations

from dataclasses import fields
from functools import cached_property
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn, Self

from toolkit.foundation.verdict import Verdict
from toolkit.scene.scene import Scene
from toolkit.sensitivity.preparation import moving
from toolkit.sensitivity.result import Result

if TYPE_CHECKING:
    from collections.abc import Sequence

    import numpy as np
    from matplotlib.figure import Figure


class Run(Result):
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
    verdict
        Whether the numbers can be trusted, with all reasons against it. It is found out when it is first asked for; that takes up to a few
        more runs with steps of other lengths.
    warnings
        The same as a tuple, doubts first.
    solution
        States at all times, and their derivatives if they were computed.
    """

    @classmethod
    def of(cls, result: Result) -> Self:
        """Run that holds the result of an analysis."""
        return cls(**{field.name: getattr(result, field.name) for field in fields(Result)})

    @cached_property
    def verdict(self) -> Verdict:
        """Whether the numbers can be trusted, and why not, see `Result.verdict`."""
        self.solution.system.refuse_changed_files()
        found: Verdict = Result.verdict.func(self)  # type: ignore[attr-defined]
        return found

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
        from toolkit.responses.stress.stress import stress_field

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
        from toolkit.render.figures import figure_of

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
        from toolkit.render.view import View

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
        from toolkit.results.results_file import save_results

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

    def _tables(self) -> list[Any]:
        from toolkit.results.short_tables import table_of_gradients, table_of_values

        return [table for table in (table_of_values(self), table_of_gradients(self)) if table is not None]


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
    from toolkit.results.restore import restore_solution
    from toolkit.results.results_file import load_results

    found = load_results(Path(path))
    solution = restore_solution(found, models)
    price = found.run["wall_primal"], found.run["wall_sensitivity"]
    return Run(found.responses, found.response_units, found.gradients, found.method, solution, *price)
