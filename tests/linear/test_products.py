"""Products with matrices on the common pattern of a system, of few terms and of many."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from toolkit.analyses.sensitivity.preparation import prepare
from toolkit.files.scene_reader import read_scene
from toolkit.system.system import LOOPED_PRODUCT_TERMS

WING = Path(__file__).parents[2] / "models" / "morphing_wing" / "scene.toml"


@pytest.mark.parametrize("columns", [1, 5, 200])
def test_products_are_those_with_the_whole_matrix(columns):
    system = prepare(read_scene(WING))
    random = np.random.default_rng(1)
    values, block = random.normal(size=len(system.plan.indices)), random.normal(size=(system.n, columns))
    wanted = system.dense(values) @ block
    assert (len(values) * columns > LOOPED_PRODUCT_TERMS) == (columns == 200)  # both ways of the product are met
    assert np.allclose(system.times(values, block), wanted, rtol=0, atol=1e-12)  # of some ten terms of size 1
    assert np.allclose(system.times(values, block, system.n_q), wanted[system.n_q :], rtol=0, atol=1e-12)
