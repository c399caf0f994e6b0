"""The report: its numbers are those of the run, its page stands alone, opens in a browser and fits its window."""

import csv
import json
import os
import re
import shutil
import subprocess
import sys
from dataclasses import replace
from html.parser import HTMLParser
from types import SimpleNamespace
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image
from typer.testing import CliRunner

from tests.models.scenes import HANGING_DESIGN, MODELS, WING, hanging_skin
from toolkit.analyses.sensitivity.direct import direct, evaluated
from toolkit.analyses.sensitivity.preparation import prepare, solve
from toolkit.analyses.sensitivity.run import restored
from toolkit.analyses.transient import simulate
from toolkit.command_line.cli import app
from toolkit.components.bodies.rigid import Rod
from toolkit.components.joints.revolute import Revolute
from toolkit.components.loads.gravity import Gravity
from toolkit.description.design import Point
from toolkit.description.run_options import RunOptions
from toolkit.files.gradient_units import per, variable_unit
from toolkit.files.results import collect, restore_scene
from toolkit.files.results_file import load_results
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.errors import InputError
from toolkit.foundation.files.safe_files import OWN, list_own, refuse_foreign, replaced
from toolkit.foundation.verdict import Verdict
from toolkit.render.packages import RenderError
from toolkit.render.pictures import file_names
from toolkit.report.answer import Answer, AnswerTable, write
from toolkit.report.figures import _scale, color_range, monitor_curves, stress_sensitivity
from toolkit.report.material import JUDGES, PATIENCE, ReportMaterial, judge
from toolkit.report.page import typeset
from toolkit.report.sections import viewer_data
from toolkit.report.tables import cost_table, gradient_table
from toolkit.report.write import begin, refuse_foreign_files, write_report
from toolkit.scene.scene import Scene

FIGURES = {
    "load_curves",
    "mechanism",
    "stress_motion",
    "skin_error_skin",
    "error_sensitivity_skin",
    "certificate",
    "monitors",
} | {f"stress_sensitivity_skin_{variable}" for variable in ("t_w", "M_t")}
ROOT = MODELS.parents[1]
VOID = {"meta", "link", "img", "input"}


class Page(HTMLParser):
    """What a page holds: pictures, addresses, identifiers, text; fails on tags that do not match."""

    def __init__(self, text):
        super().__init__()
        self.pictures, self.addresses, self.identifiers, self.open, self.words = [], [], [], [], []
        self.feed(text)
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        found = dict(attrs)
        self.addresses += [found[key] for key in ("src", "href", "action", "data") if key in found]
        self.identifiers += [found["id"]] if "id" in found else []
        self.pictures += [found] if tag == "img" else []
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.words.append(data)


def run(*arguments):
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def rows(path):
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.reader(file))


@pytest.fixture(scope="module")
def scene_file(tmp_path_factory):
    """The reference scene in steps twice as long, which make a dozen instants, with a variable of a body and one of a load."""
    folder = tmp_path_factory.mktemp("scene") / "wing"
    shutil.copytree(MODELS, folder)
    text = WING.read_text()
    assert "step = 0.05" in text
    text, left_out = re.subn(r'^(x_A|y_A|E) = "\w+\..*\n', "", text.replace("step = 0.05", "step = 0.1"), flags=re.MULTILINE)
    assert left_out == 3
    (folder / "scene.toml").write_text(text)
    return folder / "scene.toml"


@pytest.fixture(scope="module")
def wing(scene_file, tmp_path_factory):
    """Folder of the report that the command writes for this scene."""
    folder = tmp_path_factory.mktemp("report") / "new"
    done = run("report", scene_file, "-o", folder)
    assert done.exit_code == 0, done.stderr
    assert done.stdout.strip() == str(folder / "report.html")
    return folder


def pendulum(step, end_time=1.0):
    return Scene(
        units="m-kg-s",
        points={"O": Point(x=0.0, y=0.0), "P": Point(x=1.0, y=0.0)},
        bodies={"rod": Rod(between=("O", "P"), area=1e-4, density=1e3)},
        joints={"pivot": Revolute(bodies=("rod", "ground"), point="O")},
        loads={"gravity": Gravity(acceleration=(0.0, -9.81))},
        solver=RunOptions(end_time=end_time, step=step),
    )


def test_every_figure_is_there_as_png_and_svg(wing):
    assert {path.name for path in (wing / "figures").iterdir()} == {
        f"{name}.{kind}" for name in FIGURES for kind in ("png", "svg")
    }
    for name in FIGURES:
        with Image.open(wing / "figures" / f"{name}.png") as opened:
            colors = opened.convert("RGB").getcolors(opened.width * opened.height)
        assert len(colors) > 50  # smoothed letters and lines; an empty sheet has one colour
        ElementTree.parse(wing / "figures" / f"{name}.svg")
    assert {path.name for path in wing.iterdir()} == {
        "figures",
        "tables",
        "numbers.json",
        "results.h5",
        "report.html",
        OWN,
    }


def test_the_page_needs_nothing_but_itself(wing, scene_file):
    page = Page((wing / "report.html").read_text(encoding="utf-8"))
    assert all(address.startswith(("data:", "#")) for address in page.addresses)
    assert {address[1:] for address in page.addresses if address.startswith("#")} <= set(page.identifiers)
    assert len(page.pictures) == len(FIGURES)  # the motion is shown once, by the view
    assert all(picture["alt"] for picture in page.pictures)
    text = " ".join(page.words)
    assert "url(" not in text
    assert scene_file.read_text() in text  # the scene, for a stranger to repeat it
    assert load_results(wing / "results.h5").scene.models["skin.h5"] in text


def test_tables_and_json_hold_the_same_numbers(wing):
    numbers = json.loads((wing / "numbers.json").read_text())
    tables = {name: each for name, each in numbers.items() if isinstance(each, dict) and "head" in each}
    assert {path.stem for path in (wing / "tables").iterdir()} == set(tables)
    assert numbers["verdict"]["trusted"] is False  # it leaves the range of small deformations
    for name, table in tables.items():
        head, *lines = rows(wing / "tables" / f"{name}.csv")
        assert head == table["head"]
        assert lines == [[str(value) for value in row] for row in table["rows"]]


def test_the_smooth_maximum_approaches_the_true_one_from_above_within_its_bound(wing):
    table = np.array(rows(wing / "tables" / "ks_max_stress.csv")[1:], float)
    assert 200.0 in table[:, 0]
    assert np.all(table[:, 2] >= 0)
    assert np.all(table[:, 2] <= table[:, 3])
    assert np.all(np.diff(table[:, 1]) < 0)


def test_all_methods_agree_to_their_own_accuracy(wing):
    head, *lines = rows(wing / "tables" / "gradients.csv")
    assert len(lines) == 10
    # truncation and round-off of the differences; the complex step leaves the round-off of a thin skin
    for method, tolerance in (("forward-difference", 1e-2), ("central-difference", 1e-3), ("complex-step", 5e-10)):
        column = head.index(f"relative difference to {method}")
        assert max(float(line[column]) for line in lines) < tolerance, method
    assert "MPa / mm" in lines[0]


def test_the_price_of_every_method_is_listed_with_its_runs(wing):
    runs = {line[0]: int(line[1]) for line in rows(wing / "tables" / "cost.csv")[1:]}
    assert runs == {
        "primal analysis": 1,
        "primal analysis and direct differentiation": 1,
        "forward-difference": 3,
        "central-difference": 5,
        "complex-step": 2,
    }


def test_the_monitored_drift_is_that_of_the_run(wing):
    drift = np.array(rows(wing / "tables" / "monitors.csv")[1:], float)[:, 5]
    assert drift.max() == load_results(wing / "results.h5").run["drift"]


def test_the_view_shows_every_step(wing):
    results = load_results(wing / "results.h5")
    data = viewer_data(ReportMaterial(restored(results, MODELS).solution, results))
    assert [frame["time"] for frame in data["frames"]] == pytest.approx(results.times.tolist(), abs=1e-6)  # rounded for display
    assert data["limit"] == np.abs(results.bodies["skin"].stress).max()
    assert len(data["frames"][0]["rods"]) == 4


def test_a_long_motion_is_shown_in_few_frames():
    solution = solve(prepare(pendulum(0.005)), "transient")
    steps = ReportMaterial(solution, collect(evaluated(solution, gradients=False))).shown
    assert (steps[0], steps[-1]) == (0, 200)
    assert len(steps) <= 60


@pytest.mark.parametrize(
    ("scene", "design", "kind", "shown", "absent"),
    [
        (
            hanging_skin(solver=RunOptions(end_time=0.01, step=0.001)),
            HANGING_DESIGN[:2],
            "transient",
            {"skin_error_skin", "stress_sensitivity"},
            set(),
        ),
        (read_scene(WING), ["t_w"], "static", {"error_sensitivity_skin"}, {"monitors", "load_curves"}),
        (pendulum(0.02, 0.2), [], "transient", {"mechanism", "monitors"}, {"stress_motion"}),
    ],
    ids=["moving frame", "equilibrium", "rigid bodies alone"],
)
def test_every_kind_of_run_has_a_report_of_what_it_has(scene, design, kind, shown, absent, tmp_path):
    found = direct(scene, design, kind)
    path = write_report(ReportMaterial(found.solution, collect(found)), tmp_path, "A <b>title</b> & more")
    page = Page(path.read_text(encoding="utf-8"))
    assert "A <b>title</b> & more" in page.words  # shown as it is, not taken for HTML
    drawn = " ".join(file.stem for file in (tmp_path / "figures").iterdir())
    assert all(name in drawn for name in shown)
    assert not any(name in drawn for name in absent)
    assert "Not in this report" in page.words
    refuse_foreign_files(tmp_path)  # its own folder: the next report may take it


@pytest.mark.parametrize("name", ["report.html", "numbers.json", "figures/mine.svg", "results.h5"])
def test_a_report_never_overwrites_what_no_report_has_written(name, tmp_path):
    mine = tmp_path / name
    mine.parent.mkdir(exist_ok=True)
    mine.write_text("mine")
    done = CliRunner().invoke(app, ["report", str(WING), "--output", str(tmp_path)])  # refused before anything runs
    assert (done.exit_code, "ffrf has not written it" in done.stderr) == (1, True)
    with pytest.raises(InputError, match="ffrf has not written it"):
        write_report(SimpleNamespace(results=SimpleNamespace(path=None)), tmp_path, "title")
    assert mine.read_text() == "mine"
    assert [each for each in tmp_path.rglob("*") if each.is_file()] == [mine]


def test_a_report_goes_beside_its_results_and_into_the_folder_of_one_that_was_interrupted(tmp_path):
    (tmp_path / "results.h5").write_text("kept")
    refuse_foreign_files(tmp_path, tmp_path / "results.h5")
    begin(tmp_path)
    (tmp_path / "numbers.json").write_text("{}")
    refuse_foreign_files(tmp_path)


def test_results_that_a_report_is_about_stay_those_of_whoever_kept_them(tmp_path):
    kept = tmp_path / "results.h5"
    kept.write_text("kept")
    begin(tmp_path, kept)
    with pytest.raises(InputError, match=r"results\.h5' is there, and ffrf has not written it"):
        refuse_foreign_files(tmp_path)  # a report of something else


def test_a_short_peak_leaves_the_colours_to_what_is_usual():
    usual = np.linspace(-1.0, 1.0, 9) * np.ones((8, 1))
    assert color_range(usual, 1e-9) == (1.0, 0.0)
    usual[3] *= 4.5  # near enough to be shown
    assert color_range(usual, 1e-9) == (5.0, 0.0)
    usual[3] *= 10
    assert color_range(usual, 1e-9) == (1.0, 45.0)
    assert color_range(usual, 100.0) == (0.0, 0.0)  # round-off


def test_energies_and_what_their_balance_lacks_are_drawn_in_units_of_their_own():
    times = np.linspace(0.0, 1.0, 3)
    energy = SimpleNamespace(kinetic=70 * times, strain=0 * times, work=70 * times, defect=-2.5e-4 * times)
    scene = SimpleNamespace(units="m-kg-s", solver=SimpleNamespace(drift_tolerance=1e-3))
    monitors = SimpleNamespace(energy=energy, drift=1e-9 * times)
    (drawn,) = monitor_curves(SimpleNamespace(moving=True, scene=scene, monitors=monitors, solution=SimpleNamespace(times=times)))
    above, balance, _ = drawn.figure.axes
    assert (above.get_ylabel(), balance.get_ylabel()) == ("energy in J", "defect in mJ")
    assert above.lines[0].get_ydata()[-1] == 70
    assert balance.lines[0].get_ydata()[-1] == pytest.approx(-0.25, rel=1e-12)  # round-off of one product


def test_pictures_and_reports_know_each_others_files(tmp_path):
    drawn = file_names("png", animate=True, film=False)
    (tmp_path / "step-012.png").write_text("drawn")
    list_own(tmp_path, ["step-012.png"])
    refuse_foreign_files(tmp_path)
    begin(tmp_path)
    refuse_foreign(tmp_path, drawn)
    (tmp_path / "step-013.png").write_text("mine")
    for refuses in (refuse_foreign_files, lambda folder: refuse_foreign(folder, drawn)):
        with pytest.raises(InputError, match=r"step-013\.png' is there"):
            refuses(tmp_path)


FORBIDDEN = """
import sys
from toolkit.command_line.cli import app
from toolkit.analyses.sensitivity import direct, preparation

def forbidden(*_, **__):
    raise AssertionError("the run was repeated")

preparation.ANALYSES.update(transient=forbidden, static=forbidden)
direct.simulate = forbidden
app(sys.argv[1:])
"""


def test_a_report_of_results_runs_nothing_and_says_what_it_lacks(wing, tmp_path):
    """In a process of its own: monitors and figures need formulas that no run before them has compiled or loaded."""
    command = ["report", str(wing / "results.h5"), "--models", str(MODELS), "-o", str(tmp_path), "--json"]
    done = subprocess.run([sys.executable, "-c", FORBIDDEN, *command], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    record = json.loads(done.stdout)
    assert (record["report"], record["verdict"]["trusted"]) == (str(tmp_path / "report.html"), False)
    assert (tmp_path / "figures" / "skin_error_skin.svg").read_bytes() == (wing / "figures" / "skin_error_skin.svg").read_bytes()
    assert "not compared with other methods" in (tmp_path / "report.html").read_text(encoding="utf-8")
    assert rows(tmp_path / "tables" / "monitors.csv") == rows(wing / "tables" / "monitors.csv")


def test_units_of_variables_follow_from_their_paths():
    scene = read_scene(WING)
    expected = {"t_w": "mm", "M_t": "N mm", "x_A": "mm", "y_A": "mm", "E": "MPa"}
    assert {name: variable_unit(scene, path) for name, path in scene.design.items()} == expected
    assert variable_unit(scene, "bodies.body2.area") == "mm^2"
    assert variable_unit(hanging_skin(), "joints.guide.axis.x") == ""
    assert [per("MPa", "mm"), per("MPa", "N mm"), per("rad", ""), per("", "mm")] == ["MPa / mm", "MPa / (N mm)", "rad", "1 / mm"]


def test_curves_of_drivers_have_the_unit_of_what_they_drive_and_those_of_loads_are_factors():
    scene = read_scene(ROOT / "models" / "spatial_bracket" / "scene.toml")
    assert _scale(scene.joints["drive"], scene.units) == (1.0, "rotation in rad")
    scene = read_scene(ROOT / "models" / "slider_crank" / "scene.toml")
    assert _scale(scene.loads["pull"], scene.units) == (1.0, "factor")
    assert _scale(read_scene(WING).loads["drive"], "mm-t-s") == (4200.0, "torque in N mm")


BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome", "chrome"))), None)
MEASURE = """<!DOCTYPE html><iframe id="page" src="report.html" width="{width}" height="900" style="border:0"></iframe><script>
addEventListener("load", () => {{
  const page = document.getElementById("page").contentDocument, root = page.documentElement;
  const seen = (element) => element.getBoundingClientRect();
  const canvas = page.querySelector("canvas"), slider = page.querySelector("input");
  const first = canvas && canvas.toDataURL();
  if (slider) {{ slider.value = slider.max; slider.dispatchEvent(new Event("input")); }}
  document.title = JSON.stringify({{
    overflow: root.scrollWidth - root.clientWidth,
    outside: [...page.querySelectorAll("body *")].filter((e) => !e.closest(".wide, pre") && seen(e).right > {width} + 1).length,
    pictures: [...page.images].map((i) => [i.complete, i.naturalWidth, seen(i).width]),
    fetched: page.defaultView.performance.getEntriesByType("resource").filter((e) => !e.name.startsWith("data:")).length,
    moved: canvas ? first !== canvas.toDataURL() : null,
    letters: parseFloat(getComputedStyle(page.body).fontSize),
  }});
}});
</script>"""


def browse(page, folder):
    """Title of a page, and what its console said, in a headless browser that reaches no network."""
    done = subprocess.run(
        [
            BROWSER, "--headless", "--no-sandbox", "--disable-gpu", "--allow-file-access-from-files", "--virtual-time-budget=10000",
            "--host-resolver-rules=MAP * ~NOTFOUND", f"--user-data-dir={folder / 'profile'}", "--enable-logging=stderr", "--dump-dom",
            page.as_uri(),
        ],
        capture_output=True, text=True, timeout=120, check=False,
    )  # fmt: skip
    titles = re.findall("<title>(.*?)</title>", done.stdout, re.DOTALL)
    assert titles, done.stderr
    return titles[0], [line for line in done.stderr.splitlines() if "CONSOLE" in line]


@pytest.mark.skipif(BROWSER is None, reason="no Chromium or Chrome is installed; the page is tested without one above")
@pytest.mark.parametrize("width", [1280, 400])
def test_a_browser_shows_the_page_without_errors_and_without_scrolling_sideways(wing, tmp_path, width):
    shutil.copy(wing / "report.html", tmp_path)
    (tmp_path / "measure.html").write_text(MEASURE.format(width=width))
    title, console = browse(tmp_path / "measure.html", tmp_path)
    assert console == []
    found = json.loads(title)
    assert (found["overflow"], found["outside"], found["fetched"], found["moved"]) == (0, 0, 0, True)
    assert len(found["pictures"]) == len(FIGURES)
    assert all(loaded and natural for loaded, natural, _ in found["pictures"])
    assert found["letters"] >= 16
    # labels are 10 points, 13.3 pixels, in a figure at its natural size; below 8 pixels nobody reads them
    assert min(13.3 * shown / 538 for _, _, shown in found["pictures"]) >= 8


@pytest.mark.skipif(BROWSER is None, reason="no Chromium or Chrome is installed")
def test_the_browser_test_would_notice_an_error(tmp_path):
    (tmp_path / "bad.html").write_text("<title>bad</title><script>undefined.member</script>")
    title, console = browse(tmp_path / "bad.html", tmp_path)
    assert title == "bad"
    assert len(console) == 1


def test_the_settings_kept_are_those_of_the_run():
    options = RunOptions(end_time=0.05, step=0.005, scheme="paper", rho_inf=0.9)
    results = collect(evaluated(simulate(prepare(pendulum(0.02)), options), gradients=False))
    assert results.settings == options.model_dump()
    assert restore_scene(results).solver == options


@pytest.mark.skipif(hasattr(os, "geteuid") and os.geteuid() == 0, reason="nothing is read-only to the administrator")
def test_a_folder_that_cannot_be_written_is_refused(wing, tmp_path):
    (tmp_path / "locked").mkdir(mode=0o555)
    done = CliRunner().invoke(app, ["report", str(wing / "results.h5"), "-o", str(tmp_path / "locked")])
    assert done.exit_code == 1
    assert "cannot hold a report" in done.stderr


def test_a_file_that_cannot_be_written_is_an_error_of_the_program(tmp_path):
    (tmp_path / "file").write_text("no folder")
    with (
        pytest.raises(InputError, match=r"cannot be written \(.*\)\. Give a writable place"),
        replaced(tmp_path / "file" / "x.h5"),
    ):
        pass


def test_numbers_have_minus_signs_and_words_dashes_and_commands_neither():
    assert typeset("from -5 to -0.3 (-2e-3) - or so: --set x=-5 at complex-step") == (
        "from −5 to −0.3 (−2e-3) – or so: --set x=-5 at complex-step"
    )


def test_a_report_explains_the_methods_that_it_has_and_takes_what_takes_seconds():
    found = direct(read_scene(WING), ["t_w"], "static")
    plain = ReportMaterial(found.solution, collect(found))
    assert gradient_table(plain).caption == "Total derivatives of the responses."
    assert "Python" not in cost_table(plain).caption
    slow = replace(plain, results=replace(plain.results, run={**plain.results.run, "wall_primal": PATIENCE}))
    judged = judge(slow, lambda *_: None)
    assert list(judged.judges) == [
        "complex-step"
    ]  # one step of 117 unknowns, while differences would take three runs of this time
    assert "complex step" in gradient_table(judged).caption
    assert "difference" not in gradient_table(judged).caption
    assert list(judge(slow, lambda *_: None, everything=True).judges) == list(JUDGES)


def test_a_report_leaves_out_differences_for_which_a_model_lacks_other_numbers_unless_they_are_asked_for():
    scene = read_scene(WING.parents[1] / "flexible_crank" / "scene.toml", {"solver.end_time": "7.5", "solver.step": "0.5"})
    name = "E"
    found = direct(scene, [name], "transient")
    plain = ReportMaterial(found.solution, collect(found))
    assert list(judge(plain, lambda *_: None).judges) == ["complex-step"]
    with pytest.raises(InputError, match="fixed at 7e\\+10"):
        judge(plain, lambda *_: None, everything=True)


def test_a_variable_without_influence_has_no_colours_of_round_off():
    """The mass of a rod in an equilibrium without weight."""
    found = direct(read_scene(WING), ["bodies.body2.density"], "static")
    (drawing,) = stress_sensitivity(ReportMaterial(found.solution, collect(found)))
    assert drawing.figure.axes[0].get_title("left") == "at the end; no influence"


def test_an_answer_holds_without_pictures_where_they_are_not_what_was_asked_for(tmp_path, monkeypatch):
    """Tables with names are files, numbers that do not exist are null; without matplotlib that is said, or an error of a report."""

    class Few(Answer):
        name = "few"

        def record(self):
            return {"x": float("nan"), "y": [1.0, (float("inf"), "z")]}

        def tables(self):
            return [AnswerTable(["a"], [(1 / 3,)], "rows"), AnswerTable(["b"], [(2,)]), "said"]

    def missing(*_):
        raise RenderError("pictures need matplotlib")

    monkeypatch.setattr("toolkit.report.answer.require", missing)
    answer, told = Few(None, Verdict()), []
    files = write(answer, tmp_path, note=told.append)
    assert [file.name for file in files] == ["rows.csv", "few.json"]
    assert json.loads(files[1].read_text()) == {"x": None, "y": [1.0, [None, "z"]]}
    assert files[0].read_text() == "a\n0.3333333333333333\n"
    assert told == ["no pictures: pictures need matplotlib"]
    with pytest.raises(RenderError, match="need matplotlib"):
        write(answer, tmp_path)
