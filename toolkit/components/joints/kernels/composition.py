"""Rows g(h(z)) that are laws of forms: the chain rule, in the plane and in space alike."""

import numpy as np

from toolkit.components.joints.kernels.laws import ANGLE_LAW, MOST_FORMS, PLAIN_LAW, PROFILE_LAW, angle_law
from toolkit.components.joints.kernels.profile import VALUES, profile_law
from toolkit.components.joints.kernels.records import GRADIENT, LAW, PHI
from toolkit.foundation.kernel import inlined, inner


@inner
def compose(functions, law, n, i, work):
    """Row number i from its n forms: g, g_z and the products of g_zz, as those of a form."""
    h, w, g, g_h, g_hww, g_hh = work.law[0], work.law[1], work.law[2], work.law[3], work.law[4], work.law[5:]
    for f in range(n):
        rates = work.composed[i, f, 2:5]
        form_rates(work.pose, work.forms[f], rates)
        w[f], g_h[f], g_hww[f] = rates[0], 0, 0
        for k in range(n):
            g_hh[f, k] = 0
    if law == ANGLE_LAW:
        angle_law(h, w, g, g_h, g_hh, g_hww)
    elif law == PROFILE_LAW:
        profile_law(h, w, n, work.law[VALUES], g, g_h, g_hh, g_hww)
    else:
        functions[law](h, w, g, g_h, g_hh, g_hww)
    work.row[PHI, i] = g[0]
    work.slope[i, :, :] = 0
    for f in range(n):
        keep_form(f, n, i, work)
        add_form(work.forms[f], work.composed[i], f, n, work.slope[i])


@inner
def form_rates(pose, form, rates):
    """h_z w, h_z (B a), h_z b + w h_zz w of one form."""
    for k in range(3):
        rates[k] = 0
    for k in range(pose.shape[1]):
        rates[0] += form[0, k] * pose[1, k]
        rates[1] += form[0, k] * pose[2, k]
        rates[2] += form[0, k] * pose[3, k] + form[1, k] * pose[1, k]


@inner
def keep_form(f, n, i, work):
    """Keep what derivatives by the state and by the design need of one form of row number i."""
    work.composed[i, f, 0], work.composed[i, f, 1] = work.law[3, f], work.law[4, f]
    for k in range(n):
        work.composed[i, f, 5 + k] = work.law[5 + f, k]
    for k in range(work.pose.shape[1]):
        work.composed[i, f, GRADIENT + k] = work.forms[f, 0, k]


@inner
def add_form(form, composed, f, n, row):
    """Add the share of one form to its row."""
    slope, total = composed[f, 0], composed[f, 1]
    velocity, growth = 0 * slope, 0 * slope
    for k in range(n):
        bend = composed[f, 5 + k]
        velocity += bend * composed[k, 2]
        growth += bend * composed[k, 3]
        total += bend * composed[k, 4]
    for k in range(row.shape[1]):
        h_z, turn = form[0, k], form[1, k]
        row[0, k] += slope * h_z
        row[1, k] += slope * turn + velocity * h_z
        row[2, k] += slope * form[2, k] + growth * h_z
        row[3, k] += slope * form[3, k] + total * h_z + 2 * velocity * turn


@inner
def change_row(joints, j, d, lam, levels, work):
    """Derivatives of a row and of its force by a number of one of its forms, which changes that form by the one in the last place.

    The row's are left in `work.row`, the force's in `work.force[1]`.
    """
    i, f, value = joints.design[d, 1], joints.design[d, 2], work.law[0, MOST_FORMS]
    h_z, turned = work.forms[MOST_FORMS, 0], work.forms[MOST_FORMS, 1]
    rate, inertial, total = 0 * value, 0 * value, 0 * value
    for k in range(len(h_z)):
        rate += h_z[k] * work.pose[1, k]
        inertial += h_z[k] * work.pose[2, k]
        total += h_z[k] * work.pose[3, k] + turned[k] * work.pose[1, k]
        work.force[1, k] = lam * h_z[k]
    if joints.of[j, LAW + 2 * i] != PLAIN_LAW:
        composed = work.composed[i]
        slope, velocity = composed[f, 0], 0 * value
        inertial, total = slope * inertial, slope * total + composed[f, 1] * value
        for k in range(len(h_z)):
            work.force[1, k] *= slope
        for k in range(joints.of[j, LAW + 1 + 2 * i]):
            bend = composed[f, 5 + k]
            inertial += bend * value * composed[k, 3]
            total += bend * (value * composed[k, 4] + 2 * rate * composed[k, 2])
            velocity += bend * value * composed[k, 2]
            for c in range(len(h_z)):
                work.force[1, c] += lam * bend * value * work.composed[i, k, GRADIENT + c]
        rate, value = slope * rate + velocity, slope * value
    work.row[0, i] = levels[0] * inertial
    work.row[1, i] = levels[0] * total + levels[1] * rate + levels[2] * value


@inlined
def gap(joints, j, i, value, target):
    """Difference value - target of row i; of an angle that of the turn next to the target."""
    difference = value - target
    if joints.of[j, LAW + 2 * i] == ANGLE_LAW:
        difference -= 2 * np.pi * np.rint(difference.real / (2 * np.pi))
    return difference
