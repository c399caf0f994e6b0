"""Responses as a function of PyTorch, differentiated by their exact gradients."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from toolkit.bridges.packages import package
from toolkit.bridges.vector_function import VectorFunction
from toolkit.door.model import Model


def for_torch(model: Model, responses: str | Sequence[str], analysis: str = "statics") -> Callable[[Any], Any]:
    """A function of PyTorch: from the variables (n,) to the responses (m,), tensors of doubles.

    Parameters
    ----------
    model
        What `compile` has made, with the variables that x holds in their order.
    responses
        Names of the responses.
    analysis
        "statics" or "simulate".

    Returns
    -------
    function
        For `backward` and `torch.autograd`, once differentiable; `torch.autograd.gradcheck` judges it.

    Raises
    ------
    InputError
        The model has no variables, or a response is unknown.
    BridgeError
        PyTorch is not installed.

    Notes
    -----
    A tensor of single precision is refused. A design that cannot be solved raises the error of its analysis out of the forward pass.

    Examples
    --------
    >>> shape = ffrf.bridges.for_torch(model, "shape_mse")
    >>> shape(torch.tensor([1.5, 4200.0], dtype=torch.float64, requires_grad=True)).sum().backward()
    """
    torch = package("torch", "torch")
    function = VectorFunction(model, responses, analysis)

    class Responses(torch.autograd.Function):  # type: ignore[misc, name-defined]  # its base is known only where PyTorch is installed
        """Responses of a scene by its design variables."""

        @staticmethod
        def forward(context: Any, x: Any) -> Any:
            if x.dtype != torch.float64:
                raise TypeError(f"this function takes doubles, not {x.dtype}. Write x.double(), or dtype=torch.float64.")
            values, slopes = function.both(x.detach().cpu().numpy())
            context.save_for_backward(torch.from_numpy(slopes).to(x.device))
            return torch.from_numpy(values).to(x.device)

        @staticmethod
        @torch.autograd.function.once_differentiable  # type: ignore[untyped-decorator]
        def backward(context: Any, cotangent: Any) -> Any:
            (slopes,) = context.saved_tensors
            return cotangent @ slopes

    def responses_of(x: Any) -> Any:
        """Responses (m,) at the variables (n,)."""
        return Responses.apply(x)

    return responses_of
