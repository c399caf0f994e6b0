"""All methods by the names that a study writes."""

from __future__ import annotations

from toolkit.studies.optimization.methods.functions import Method
from toolkit.studies.optimization.methods.nlopt_methods import ccsa, mma
from toolkit.studies.optimization.methods.scipy_methods import slsqp, trust_constr

METHODS: dict[str, Method] = {"slsqp": slsqp, "trust-constr": trust_constr, "mma": mma, "ccsa": ccsa}
TURNED = ("slsqp",)
"""Those that learn the curvature from the identity on, and take bounds as well as constraints: they begin anew in other variables."""
