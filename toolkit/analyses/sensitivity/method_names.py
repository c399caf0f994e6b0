"""Names of the methods for gradients; the only list of them."""

from enum import StrEnum


class GradientMethod(StrEnum):
    """How gradients are computed; `auto` takes the cheaper of the exact ones, direct and adjoint."""

    auto = "auto"
    direct = "direct"
    adjoint = "adjoint"
    complex_step = "complex-step"
    forward_difference = "forward-difference"
    central_difference = "central-difference"


METHODS = tuple(method.value for method in GradientMethod)
NUMERICAL = tuple(
    method.value for method in (GradientMethod.complex_step, GradientMethod.forward_difference, GradientMethod.central_difference)
)
