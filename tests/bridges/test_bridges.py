"""Every bridge judged by the checker of the package that it leads to, on a truss whose slopes are known; and what failed designs do."""

from __future__ import annotations

import pickle
import subprocess
import sys
from collections import namedtuple
from concurrent.futures import ThreadPoolExecutor
from importlib.util import find_spec
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import NonlinearConstraint, minimize

import ffrf
from tests.models.truss import force, force_slope, height, limit_load, write_truss
from toolkit.bridges.openmdao_component import openmdao_units
from toolkit.bridges.vector_function import BridgeError, VectorFunction
from toolkit.foundation.errors import InputError, ToolkitError
from toolkit.foundation.units import LABELLED, UNIT_SYSTEMS, factor, unit

LOAD, STIFFNESS = "loads.push.force.y", "loads.left.stiffness"
BEYOND = -1.1 * limit_load()
STEP = 1e-4
"""Of differences, in parts of a variable: the square of it times a third derivative of some tens, and round-off over it, are below 1e-8."""


@pytest.fixture(scope="module")
def model(tmp_path_factory):
    folder = tmp_path_factory.mktemp("truss")
    write_truss(folder)
    return ffrf.compile(ffrf.read_scene(folder / "scene.toml"), [LOAD, STIFFNESS])


def test_values_and_slopes_for_scipy_are_those_of_the_closed_form(model):
    function = ffrf.bridges.for_scipy(model, "rise")
    assert function.names == (LOAD, STIFFNESS)
    assert function.x0 == pytest.approx([-30.0, 1000.0])
    assert function.last is None
    y = height(30.0)
    assert function.fun(function.x0) == pytest.approx(y - 0.5, rel=1e-10)
    assert function.jac(function.x0)[0] == pytest.approx(-1 / force_slope(y), rel=1e-9)
    assert function.last.values["rise"] == function.fun(function.x0)


def test_scipy_finds_the_load_that_a_drop_takes(model):
    drop, both = ffrf.bridges.for_scipy(model, "rise"), ffrf.bridges.for_scipy(model, ["rise", "sway"])
    assert both.jac(both.x0).shape == (2, 2)
    one = np.array([1.0, 0.0])
    found = minimize(
        lambda t: drop.fun(drop.x0 + t[0] * one), [0.0], jac=lambda t: drop.jac(drop.x0 + t[0] * one) @ one[:, None], method="SLSQP",
        constraints=NonlinearConstraint(
            lambda t: both.fun(both.x0 + t[0] * one)[0], -0.12, 1.0, jac=lambda t: (both.jac(both.x0 + t[0] * one) @ one)[:1, None]
        ), options={"ftol": 1e-14},
    )  # fmt: skip
    assert 30.0 - found.x[0] == pytest.approx(force(0.38), rel=1e-6)


class Row:
    """What a row of pandas shows of itself: labels, and numbers in their order."""

    def __init__(self, numbers, index=None):
        self.index, self.numbers = list(range(len(numbers))) if index is None else index, list(numbers)

    def __array__(self, dtype=None, copy=None):
        return np.array(self.numbers, dtype)


def test_a_design_with_names_is_taken_by_its_names(model):
    fun, (load, stiffness) = ffrf.bridges.for_scipy(model, "rise").fun, (-30.0, 1000.0)
    expected = pytest.approx(height(30.0) - 0.5, rel=1e-10)
    assert fun(Row([stiffness, load], [STIFFNESS, LOAD])) == expected
    assert fun({STIFFNESS: stiffness, LOAD: load}) == expected
    assert fun(Row([load, stiffness])) == expected  # numbered from zero, as of a table without names
    assert fun([load, stiffness]) == expected


@pytest.mark.parametrize(
    ("x", "words"),
    [
        (Row([1000.0, -30.0], [STIFFNESS, "loads.push.force.z"]), f"'loads.push.force.z' is no variable, did you mean '{LOAD}'"),
        (Row([1000.0, -30.0], [1, 0]), "1 is no variable"),
        (Row([1000.0, -30.0], [LOAD, LOAD]), "two of them are the same"),
        ({STIFFNESS: 1000.0}, f"'{LOAD}' is not among them"),
        (namedtuple("Sizes", "k F")(1000.0, -30.0), "'k' is no variable"),
        ("ab", "2 finite numbers"),
        ({LOAD: "x", STIFFNESS: 1.0}, "2 finite numbers"),
    ],
)
def test_names_that_are_not_those_of_the_variables_are_refused(model, x, words):
    with pytest.raises(InputError, match=words):
        ffrf.bridges.for_scipy(model, "rise").fun(x)


@pytest.mark.skipif(find_spec("pandas") is None, reason="pandas is no part of what the tests install")
def test_a_row_of_pandas_is_taken_by_its_names(model):
    import pandas

    table = pandas.DataFrame({STIFFNESS: [1000.0, 1000.0], LOAD: [-20.0, -30.0]})
    fun = ffrf.bridges.for_scipy(model, "rise").fun
    assert fun(table.iloc[1]) == pytest.approx(height(30.0) - 0.5, rel=1e-10)
    assert fun(table[[LOAD, STIFFNESS]].iloc[0]) == pytest.approx(height(20.0) - 0.5, rel=1e-10)
    with pytest.raises(InputError, match="2 finite numbers"):
        fun(table)


def test_a_function_for_scipy_goes_to_another_process_before_and_after_its_first_value(model):
    function = ffrf.bridges.for_scipy(model, "rise")
    before = pickle.dumps(function.fun)
    value, slopes = function.fun(function.x0), function.jac(function.x0)
    for sent in (before, pickle.dumps(function.fun)):
        again = pickle.loads(sent).__self__  # noqa: S301 (it was made here)
        assert again.last is None
        assert (again.fun(function.x0), again.jac(function.x0).tolist()) == (value, slopes.tolist())


class Quick:
    """A model whose runs take no time, so that threads meet often."""

    def run(self, _kind, numbers, gradients):
        assert gradients
        return SimpleNamespace(
            values={"rise": numbers[LOAD]}, gradients={"rise": {LOAD: 2 * numbers[LOAD], STIFFNESS: numbers[STIFFNESS]}}
        )


def test_threads_that_share_a_function_get_the_numbers_of_their_own_designs(model, monkeypatch):
    function = VectorFunction(model, "rise")
    monkeypatch.setattr(function, "_model", Quick())
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    try:
        with ThreadPoolExecutor(4) as pool:
            found = list(pool.map(lambda k: function.both([k, -k]), [k % 7 for k in range(4000)]))
    finally:
        sys.setswitchinterval(interval)
    assert [(value[0], *slopes[0]) for value, slopes in found] == [(k % 7, 2 * (k % 7), -(k % 7)) for k in range(4000)]


def test_openmdao_agrees_with_the_partials_and_is_told_of_failures_by_its_own_error(model):
    import openmdao.api as om

    problem = om.Problem(reports=False)
    problem.model.add_subsystem("truss", ffrf.bridges.for_openmdao(model, ["rise"]), promotes=["*"])
    problem.setup()
    problem.run_model()
    assert problem.get_val("rise") == pytest.approx(height(30.0) - 0.5)
    checked = problem.check_partials(out_stream=None, form="central", step=STEP, step_calc="rel_element")["truss"]
    assert {key: error["rel error"].forward < 1e-8 for key, error in checked.items()} == {
        ("rise", LOAD.replace(".", "_")): True,
        ("rise", STIFFNESS.replace(".", "_")): True,
    }
    problem.set_val("loads_push_force_y", BEYOND)
    with pytest.raises(om.AnalysisError, match="limit point"):
        problem.run_model()
    with pytest.raises(InputError, match="cannot tell these apart"):
        ffrf.bridges.for_openmdao(model, ["rise", "rise"])
    scene = model.scene.model_copy(update={"responses": {"solved": model.scene.responses["rise"]}})
    with pytest.raises(InputError, match="'solved' is the output"):
        ffrf.bridges.for_openmdao(ffrf.compile(scene, [LOAD]), "solved")


def test_openmdao_converts_to_the_units_of_the_scene(model):
    import openmdao.api as om

    problem = om.Problem(reports=False)
    source = problem.model.add_subsystem("source", om.IndepVarComp())
    source.add_output("load", val=-0.03, units="kN")
    problem.model.add_subsystem("truss", ffrf.bridges.for_openmdao(model, ["rise"]))
    problem.model.connect("source.load", "truss.loads_push_force_y")
    problem.setup()
    problem.run_model()
    assert problem.get_val("truss.rise", units="mm") == pytest.approx(1000 * (height(30.0) - 0.5))
    assert problem.get_val("truss.loads_left_stiffness", units="N/mm") == pytest.approx(1.0)


@pytest.mark.parametrize("system", UNIT_SYSTEMS)
def test_openmdao_knows_the_units_of_both_systems_with_their_sizes(system):
    from openmdao.utils.units import convert_units

    own = {quantity: openmdao_units(unit(system, quantity)) for quantity in LABELLED}
    assert [quantity for quantity, label in own.items() if label is None] == ["none"]
    for quantity, dimension in LABELLED.items():
        if own[quantity] is not None:
            base = openmdao_units(unit("m-kg-s", quantity))
            assert convert_units(1.0, own[quantity], base) == pytest.approx(factor(dimension, system, "m-kg-s"))
    assert openmdao_units("N mm/(rad s)^2") == "N*mm/(rad*s)**2"
    assert convert_units(1.0, "N*mm/(rad*s)**2", "N*m/rad**2/s**2") == pytest.approx(1e-3)


@pytest.mark.parametrize("label", ["", "?", "9^9^9^9", "().__class__", "ft", "N*", "m^10"])
def test_what_is_no_unit_of_the_toolkit_is_not_handed_to_openmdao(label):
    assert openmdao_units(label) is None


def test_an_output_tells_openmdao_which_designs_were_solved(model, tmp_path):
    """A design of experiments goes on after a failure, and records the outputs of the design before."""
    import openmdao.api as om

    problem = om.Problem(reports=False)
    problem.model.add_subsystem("truss", ffrf.bridges.for_openmdao(model, ["rise"]), promotes=["*"])
    problem.model.add_design_var("loads_push_force_y")
    problem.model.add_objective("rise")
    problem.driver = om.DOEDriver(om.ListGenerator([[("loads_push_force_y", load)] for load in (-30.0, BEYOND, -20.0)]))
    problem.driver.recording_options["includes"] = ["solved"]
    problem.driver.add_recorder(om.SqliteRecorder(str(tmp_path / "cases.sql")))
    problem.setup()
    problem.run_driver()
    problem.cleanup()
    reader = om.CaseReader(str(tmp_path / "cases.sql"))
    cases = [reader.get_case(each) for each in reader.list_cases("driver", out_stream=None)]
    assert [case["solved"][0] for case in cases] == [1.0, 0.0, 1.0]
    assert [case["rise"][0] for case in cases if case["solved"]] == pytest.approx([height(30.0) - 0.5, height(20.0) - 0.5])


@pytest.fixture
def jax():
    """JAX in double precision, and as it was afterwards."""
    import jax

    before = jax.config.jax_enable_x64
    jax.config.update("jax_enable_x64", True)
    yield jax
    jax.config.update("jax_enable_x64", before)


def test_jax_agrees_with_the_gradients_also_compiled_and_of_many(model, jax):
    from jax.test_util import check_grads

    function, sizes = ffrf.bridges.for_jax(model, ["rise"]), np.array([-30.0, 1000.0])
    check_grads(lambda z: function(z * sizes), (np.ones(2),), order=1, modes=["rev"], atol=1e-8, rtol=1e-8, eps=STEP)
    slope = jax.jit(jax.grad(lambda x: function(x)[0]))(jax.numpy.array(sizes))
    assert slope[0] == pytest.approx(-1 / force_slope(height(30.0)), rel=1e-9)
    many = jax.vmap(function)(jax.numpy.array([sizes, [-20.0, 1000.0]]))
    assert np.array(many)[:, 0] == pytest.approx([height(30.0) - 0.5, height(20.0) - 0.5], rel=1e-9)


def test_a_failed_design_is_an_error_of_jax(model, jax):
    function = ffrf.bridges.for_jax(model, ["rise"])
    with pytest.raises(jax.errors.JaxRuntimeError, match="limit point"):
        function(jax.numpy.array([BEYOND, 1000.0])).block_until_ready()
    with pytest.raises(TypeError, match="the 2 variables"):
        function(jax.numpy.array([1.0]))
    for made in (function, jax.jit(function), jax.grad(lambda x: function(x)[0].real, holomorphic=False)):
        with pytest.raises(TypeError, match=r"no complex step|real-valued"):
            made(jax.numpy.array([-30.0 + 1e-3j, 1000.0]))
    with pytest.raises(TypeError, match="no named tuple"):
        function(namedtuple("Sizes", "k F")(1000.0, -30.0))
    with pytest.raises(ValueError, match="JVP"):
        jax.hessian(lambda x: function(x)[0])(jax.numpy.array([-30.0, 1000.0]))


def test_jax_in_single_precision_is_refused(model, jax):
    jax.config.update("jax_enable_x64", False)
    with pytest.raises(BridgeError, match="jax_enable_x64"):
        ffrf.bridges.for_jax(model, ["rise"])


def test_a_bridge_to_what_is_not_installed_says_what_to_install(model, monkeypatch):
    monkeypatch.setitem(sys.modules, "torch", None)
    with pytest.raises(BridgeError, match=r"ffrf-toolkit\[torch\]"):
        ffrf.bridges.for_torch(model, ["rise"])


TORCH = pytest.mark.skipif(
    find_spec("torch") is None, reason="PyTorch is no part of what the tests install: make torch runs this"
)


@TORCH
def test_torch_agrees_with_the_gradients(model):
    import torch

    function = ffrf.bridges.for_torch(model, ["rise"])
    sizes = torch.tensor([-30.0, 1000.0], dtype=torch.float64)
    z = torch.ones(2, dtype=torch.float64, requires_grad=True)
    assert torch.autograd.gradcheck(lambda z: function(z * sizes), (z,), eps=STEP, atol=1e-8, rtol=1e-8)
    with pytest.raises(ToolkitError, match="limit point"):
        function(torch.tensor([BEYOND, 1000.0], dtype=torch.float64))
    for other in (sizes.float(), sizes * 1j, [-30.0, 1000.0]):
        with pytest.raises(TypeError, match="a tensor of doubles"):
            function(other)


@TORCH
def test_first_derivatives_along_a_direction_are_right_in_torch(model):
    """PyTorch finds them by differentiating a gradient by its cotangent, which is no second derivative of the responses."""
    from torch import float64, tensor
    from torch.autograd import functional

    function, x = ffrf.bridges.for_torch(model, ["rise"]), tensor([-30.0, 1000.0], dtype=float64)
    assert functional.jvp(function, x, tensor([1.0, 0.0], dtype=float64))[1] == pytest.approx(
        -1 / force_slope(height(30.0)), rel=1e-9
    )


def penalty(function, x):
    """Gradient of a function that has the gradient of another one in it."""
    import torch

    (slope,) = torch.autograd.grad(function(x), x, create_graph=True)
    return torch.autograd.grad(function(x) + slope.pow(2).sum(), x)


@TORCH
@pytest.mark.parametrize("which", ["hessian", "hvp", "vhp", "penalty"])
def test_second_derivatives_of_torch_are_refused(model, which):
    """They were exact zeros."""
    import torch

    function = ffrf.bridges.for_torch(model, ["rise"])
    x = torch.tensor([-30.0, 1000.0], dtype=torch.float64, requires_grad=True)
    asked = penalty if which == "penalty" else getattr(torch.autograd.functional, which)
    direction = (torch.ones(2, dtype=torch.float64),) if which in ("hvp", "vhp") else ()
    with pytest.raises(BridgeError, match="only first ones are known"):
        asked(lambda x: function(x)[0], x, *direction)


@pytest.mark.parametrize(
    ("x", "words"),
    [([1.0], "2 finite numbers"), ([np.nan, 1.0], "2 finite numbers"), ([1j, 1.0], "no complex step")],
)
def test_what_is_no_design_is_refused(model, x, words):
    with pytest.raises(InputError, match=words):
        ffrf.bridges.for_scipy(model, "rise").fun(np.array(x))


def test_bridges_of_nothing_are_refused(model):
    with pytest.raises(InputError, match="no response 'fall'; possible here: rise, sway"):
        ffrf.bridges.for_scipy(model, "fall")
    with pytest.raises(InputError, match="no design variables"):
        ffrf.bridges.for_scipy(ffrf.compile(model.scene), "rise")
    with pytest.raises(InputError, match="begins at a model"):
        ffrf.bridges.for_scipy(model.scene, "rise")
    with pytest.raises(ToolkitError, match="limit point"):
        ffrf.bridges.for_scipy(model, "rise").fun(np.array([BEYOND, 1000.0]))


def test_bridges_cost_no_import_of_the_other_side():
    code = "import sys, toolkit; toolkit.bridges.for_jax; print({'jax', 'openmdao', 'torch', 'nlopt'} & set(sys.modules))"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "set()\n"
