"""Work and energy of a spatial mechanism: driver, spring-damper, torques fixed in space and in a body, weight, damped flexible rod."""

from __future__ import annotations

import numpy as np
import pytest

from tests.spatial.mechanism import spatial_crank
from tests.spatial.momenta import kinetic_energy, strain_energy
from toolkit.analyses.transient import simulate
from toolkit.description.run_options import RunOptions
from toolkit.system.system import compile_scene
from toolkit.validity.energy_balance import energy_balance


@pytest.fixture(scope="module")
def system(tmp_path_factory):
    return compile_scene(spatial_crank(tmp_path_factory.mktemp("crank")).model_copy(update={"responses": {}}))


@pytest.mark.parametrize(("formulation", "rho_inf"), [("index-1", 1.0), ("index-3", 0.8)])
def test_work_and_energy_balance_to_second_order(system, formulation, rho_inf):
    defects = []
    for steps in (200, 400):
        run = simulate(
            system, RunOptions(end_time=0.5, step=0.5 / steps, rho_inf=rho_inf, formulation=formulation, tolerance=1e-12)
        )
        balance = energy_balance(run)
        defects.append(balance.relative_defect)
    assert defects[1] < 5e-5
    assert np.log2(defects[0] / defects[1]) == pytest.approx(2.0, abs=0.1)
    last = run.q[-1], run.v[-1]
    assert balance.kinetic[-1] == pytest.approx(kinetic_energy(system, *last), rel=1e-12)
    assert balance.strain[-1] == pytest.approx(strain_energy(system, last[0]), rel=1e-9)
