"""Every bridge judged by the checker of the package that it leads to, on a truss whose slopes are known; and what failed designs do."""

from __future__ import annotations

import subprocess
import sys
from importlib.util import find_spec

import numpy as np
import pytest
from scipy.optimize import NonlinearConstraint, minimize

import toolkit as ffrf
from tests.models.truss import force, force_slope, height, limit_load, write_truss
from toolkit.bridges.packages import BridgeError
from toolkit.foundation.errors import InputError, ToolkitError

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


def test_jax_in_single_precision_is_refused(model, jax):
    jax.config.update("jax_enable_x64", False)
    with pytest.raises(BridgeError, match="jax_enable_x64"):
        ffrf.bridges.for_jax(model, ["rise"])


def test_a_bridge_to_what_is_not_installed_says_what_to_install(model, monkeypatch):
    monkeypatch.setitem(sys.modules, "torch", None)
    with pytest.raises(BridgeError, match=r"ffrf-toolkit\[torch\]"):
        ffrf.bridges.for_torch(model, ["rise"])


@pytest.mark.skipif(find_spec("torch") is None, reason="PyTorch is no part of what the tests install: make torch runs this")
def test_torch_agrees_with_the_gradients(model):
    import torch

    function = ffrf.bridges.for_torch(model, ["rise"])
    sizes = torch.tensor([-30.0, 1000.0], dtype=torch.float64)
    z = torch.ones(2, dtype=torch.float64, requires_grad=True)
    assert torch.autograd.gradcheck(lambda z: function(z * sizes), (z,), eps=STEP, atol=1e-8, rtol=1e-8)
    with pytest.raises(ToolkitError, match="limit point"):
        function(torch.tensor([BEYOND, 1000.0], dtype=torch.float64))
    with pytest.raises(TypeError, match="doubles"):
        function(sizes.float())


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
