"""Responses as a function of PyTorch, differentiated by their exact gradients."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NoReturn

from toolkit.api.model import Model
from toolkit.bridges.vector_function import BridgeError, VectorFunction, package

if TYPE_CHECKING:
    from torch import Tensor
    from torch.autograd.function import FunctionCtx


def for_torch(model: Model, responses: str | Sequence[str], analysis: str = "statics") -> Callable[[Tensor], Tensor]:
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
        For `backward` and `torch.autograd`, once differentiable, in reverse; `torch.autograd.gradcheck` judges it.

    Raises
    ------
    InputError
        The model has no variables, or a response is unknown.
    BridgeError
        PyTorch is not installed.

    Notes
    -----
    A tensor of single precision is refused. A design that cannot be solved raises the error of its analysis out of the forward pass. A
    second derivative (`hessian`, `hvp`, a penalty on a gradient) raises `BridgeError`.

    Examples
    --------
    >>> shape = ffrf.bridges.for_torch(model, "shape_mse")
    >>> shape(torch.tensor([1.5, 4200.0], dtype=torch.float64, requires_grad=True)).sum().backward()
    """
    torch = package("torch", "torch")
    function = VectorFunction(model, responses, analysis)

    class TorchResponses(torch.autograd.Function):  # type: ignore[misc, name-defined]  # its base is known only where PyTorch is installed
        """Responses of a scene by its design variables."""

        @staticmethod
        def forward(context: FunctionCtx, x: Tensor) -> Tensor:
            if not isinstance(x, torch.Tensor) or x.dtype != torch.float64:
                given = x.dtype if isinstance(x, torch.Tensor) else type(x).__name__
                raise TypeError(
                    f"this function takes a tensor of doubles, not {given}. Write x.double(), or torch.tensor(x, dtype=torch.float64)."
                )
            values, slopes = function.both(x.detach().cpu().numpy())
            context.save_for_backward(x, torch.from_numpy(slopes).to(x.device))
            return torch.from_numpy(values).to(x.device)

        @staticmethod
        def backward(context: FunctionCtx, cotangent: Tensor) -> Tensor:
            return cotangent @ TorchSlopes.apply(*context.saved_tensors)

    class TorchSlopes(torch.autograd.Function):  # type: ignore[misc, name-defined]
        """First derivatives (m, n), which depend on the variables.

        They must not be taken for constants, whose derivatives are zeros.
        """

        @staticmethod
        def forward(_context: FunctionCtx, _x: Tensor, slopes: Tensor) -> Tensor:
            return slopes.clone()

        @staticmethod
        def backward(_context: FunctionCtx, _cotangent: Tensor) -> NoReturn:
            raise BridgeError(
                "second derivatives of these responses are asked for, and only first ones are known. For a Hessian take differences of the "
                "gradients, which are exact; leave penalties on gradients out of what is minimized."
            )

    def responses_of(x: Tensor) -> Tensor:
        """Responses (m,) at the variables (n,)."""
        return TorchResponses.apply(x)

    return responses_of
