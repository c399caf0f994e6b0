"""Places that joints in space have in the loop's matrices: those of entries that are never anything would cost every correction."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.models.spatial_cases import KINDS, SpatialCase
from toolkit.api.comparison import inputs, random_state
from toolkit.components.joints.joint import Joint
from toolkit.components.joints.kernels.laws import angle_law
from toolkit.system.system import System, compile_scene

JOINTS = [(name, kind, numbers) for name, kind, numbers in KINDS if issubclass(kind, Joint)]


def on_rigid_bodies(name: str, kind: type, numbers: dict) -> System:
    return compile_scene(SpatialCase(name, kind, numbers, ("block", "rod"), ("A", "O"), "O").scene(Path()))


@pytest.mark.parametrize("joint", JOINTS, ids=lambda joint: joint[0])
def test_what_a_joint_stores_in_its_rows_and_between_bodies_is_something(joint):
    """That nothing is missing is what complex steps of the same joints show (`tests.equations.test_spatial_conformance`).

    How open formulas bend nobody knows, so that their coordinates may all meet.
    """
    system = on_rigid_bodies(*joint)
    terms = system.evaluate(inputs(system), *random_state(system))
    filled = system.matrix(np.any([terms.I_acc, terms.I_q, terms.A_q, terms.A_v], axis=0).astype(float)).toarray() != 0
    rows, columns = np.repeat(np.arange(system.n), np.diff(system.plan.indptr)), system.plan.indices
    owner = np.searchsorted([*system.numbering.first.values(), *range(system.n_q, system.n)], np.arange(system.n), side="right")
    apart, names = owner[rows] != owner[columns], system.numbering.names
    if any(row.law not in (None, angle_law) for each in system.numbering.forms.rows for row in each):
        apart &= np.maximum(rows, columns) >= system.n_q
    stored = [(i, k) for i, k in zip(rows[apart], columns[apart], strict=True)]
    assert not [(names[i], names[k]) for i, k in stored if not filled[i, k] and not filled[k, i]]


def test_a_ball_joint_stores_nothing_between_two_bodies():
    """Each of its rows feels one translation and the four orientation coordinates of either body, there and back; and itself."""
    system = on_rigid_bodies("spherical", *next(joint[1:] for joint in JOINTS if joint[0] == "spherical"))
    rows, columns = np.repeat(np.arange(system.n), np.diff(system.plan.indptr)), system.plan.indices
    of_first, of_second = (system.numbering.first[body] + np.arange(7) for body in ("rod", "block"))
    assert not np.any(np.isin(rows, of_first) & np.isin(columns, of_second))
    own = system.numbering.row["component"] + np.arange(3)
    assert np.count_nonzero(np.isin(rows, own)) == 3 * (2 * 5 + 1)
