"""Joints that repeat each other, left out of a system on request, with what that must not hide."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import scipy

from toolkit.foundation.errors import InputError, NoDerivativeError
from toolkit.system.equations import Terms
from toolkit.system.redundant_rows import Rows, hint_of_grounded, independent_rows, null_vectors

if TYPE_CHECKING:
    from toolkit.system.system import System

JAMMING_PART = 1e-6
"""Part of the joints' own changes that is left of them in the motions that are free, above which it is no round-off."""


def whole(system: System) -> System:
    """System with all rows of its joints."""
    return replace(system, plan=system.plan._replace(dropped=np.zeros(0, np.int64)))


def joint_terms(system: System, q: np.ndarray, acc: np.ndarray) -> Terms:
    """Terms of the joints alone at coordinates q (n,), all rows: J^T lam, and J a in their rows, for acc = [a; lam] (n,)."""
    inputs = system.inputs(0.0, np.array([1.0, 0, 0]))._replace(joints_only=True)
    return whole(system).evaluate(inputs, q, 0 * q, acc, design=True)


def without_redundant_rows(system: System) -> System:
    """System with multipliers zero in the place of constraints that repeat others at the start.

    Raises
    ------
    InputError
        A driver is redundant, joints repeat each other nearly but not exactly, or a design variable would make them not fit any more.
    """
    q, n_q, names = system.start()[0], system.n_q, system.numbering.names
    jacobian = system.dense(joint_terms(system, q, 0 * q).I_acc)[n_q:, :n_q]
    lengths = np.array(list(system.numbering.length.values()), int) - n_q
    rows = independent_rows(jacobian, system.weights[:n_q], lengths)
    if len(rows.almost):
        raise InputError(
            f"{', '.join(names[n_q + row] for row in rows.almost[:4])} nearly repeat what other joints hold, but not exactly: they jam. "
            "Give points and axes that fit to the last digit, or remove the joint that is too much."
            + hint_of_grounded(system.scene, system.numbering.joints_of(n_q + rows.almost))
        )
    joints = system.scene.joints.items()
    driven = {system.numbering.row[name] + len(joint.row_names) - 1 for name, joint in joints if joint.time_curve}
    if repeated := driven & {n_q + int(row) for row in rows.repeating}:
        raise InputError(
            f"{names[min(repeated)]} drives what other joints already determine. Remove the driver, or the joint that holds what it drives."
            + hint_of_grounded(system.scene, system.scene.joints)
        )
    _refuse_variables_that_jam(system, q, jacobian, rows)
    return replace(system, plan=system.plan._replace(dropped=n_q + rows.repeating))


def _refuse_variables_that_jam(system: System, q: np.ndarray, jacobian: np.ndarray, rows: Rows) -> None:
    """Refuse design variables by which repeating rows would cease to repeat others.

    They go on to do so where N^T dJ z = 0 for all motions z that the joints leave, J z = 0.
    """
    if not system.n_x or not len(rows.repeating):
        return
    N, dq, n_q = null_vectors(np.real(jacobian), rows.kept, rows.repeating), system.start()[2], system.n_q

    def change(motion: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Change dJ z by every variable, (n_lam, n_x), and the size of the largest terms that it is the sum of, (n_x,)."""
        acc: np.ndarray = np.concatenate([motion, np.zeros(system.n - n_q)]).astype(system.dtype)
        terms = joint_terms(system, q, acc)
        by_q, by_x = np.real(system.matrix(terms.I_q)), np.real(terms.I_x)
        made_of = np.abs(by_q) @ np.abs(np.real(dq)) + np.abs(by_x)
        return (by_q @ np.real(dq) + by_x)[n_q:], made_of[n_q:].max(axis=0, initial=0)

    size = change(1 / system.weights[:n_q])[1]
    for motion in scipy.linalg.null_space(np.real(jacobian)[rows.kept]).T:
        jams = np.flatnonzero(np.abs(N.T @ change(motion)[0]).max(axis=0) > JAMMING_PART * size)
        if len(jams):
            raise NoDerivativeError(
                f"design variable {system.design.names[jams[0]]!r} would make joints that repeat each other fit no more, and jam the "
                "mechanism: its motion has no derivative by it. Leave it out, or remove the joint that is too much.",
                tuple(system.design.names[each] for each in jams),
            )
