"""All methods by the names that a study writes."""

from __future__ import annotations

from toolkit.studies.optimization.methods.functions import Method
from toolkit.studies.optimization.methods.nlopt_methods import ccsa, mma
from toolkit.studies.optimization.methods.scipy_methods import INSIDE, NEAR, slsqp, trust_constr

METHODS = {
    "slsqp": Method(slsqp, learned=10, told=5),
    "trust-constr": Method(trust_constr, told=5, inside=INSIDE, near=NEAR),
    "mma": Method(mma, told=1),
    "ccsa": Method(ccsa, told=1),
}
"""SLSQP learns the curvature anew each time. MMA and CCSA never do, and begin anew with every step where it is told; the interior-point
method takes it as it is told, in variables in which that is round."""
