"""Floating frames of a flexible body as a scene writes them, in the plane and in space."""

from abc import abstractmethod
from typing import Annotated, Any, Literal, NamedTuple, Self

import numpy as np
from pydantic import Field, PrivateAttr, field_validator, model_validator

from toolkit.components.bodies.model_body import DEPENDENCE, ModelBody
from toolkit.description.description import Quantity


class ChosenFrames(NamedTuple):
    """Number of floating frames that runs of the scene have chosen for a body, and what it was chosen by."""

    wanted: float  # geometric error, in parts of the largest displacement of the body
    error: float  # what the last of these runs leaves, estimated
    numbers: tuple[int, ...]  # of frames, one run after the other
    analysis: str
    gradients: tuple[
        tuple[int, float], ...
    ] = ()  # further numbers of frames, and by how much these gradients may be off, in parts of them
    metered: float = float("nan")  # what the meter of large deformation finds in the run whose error that is, likewise
    failed: int = 0  # frames of a run that failed, after which no more were tried
    kept_run: str = ""  # file of the run that the scene starts in, whose number was taken without any run


class CuttableBody(ModelBody):
    """A flexible body that a scene may cut into parts, each with a floating frame.

    Attributes
    ----------
    frames
        Into how many parts, with a floating frame each, the body is cut inside: one frame is exact for small rotations of the body against
        it, and the error falls with the square of their number. Or nodes where it is cut: their numbers from the beginning of the body, or
        names of interface points of the reduced model. It needs a model of beams, whose parts then have all nodal coordinates whatever
        its basis; where beams branch, they are always cut.
        "auto" takes the number that runs of the scene with fewer and more frames find to be enough for `geometric_error`, and where
        gradients are wanted, for these too.
    modes_per_frame
        How many fixed-interface modes each part keeps, beside the coordinates at its ends and at the points of the scene on it
        (Craig-Bampton); as many more as have the same frequency as the last. Left out, all coordinates of the part's nodes are kept.
    geometric_error
        With `frames = "auto"`: how far nodes may be from where ever more frames would bring them, in parts of the body's largest
        displacement; by default 0.01.
    """

    kind = ""

    frames: Annotated[int, Field(ge=1, strict=True)] | Literal["auto"] | tuple[Annotated[int, Field(strict=True)] | str, ...] = 1
    modes_per_frame: Annotated[int, Field(ge=0, strict=True)] | None = None
    geometric_error: Annotated[Annotated[float, Field(gt=0, lt=1, allow_inf_nan=False)] | None, Quantity("1")] = None

    _choice: ChosenFrames | None = PrivateAttr(None)

    @field_validator("frames", mode="before")
    @classmethod
    def _number_or_nodes(cls, frames: object) -> object:
        if (
            isinstance(frames, bool | float | dict)
            or (isinstance(frames, list | tuple) and not all(type(place) in (int, str) for place in frames))
            or (isinstance(frames, str) and frames != "auto")
            or (isinstance(frames, int) and frames < 1)
        ):
            raise ValueError('is a whole number from 1 up, "auto", or a list of nodes and interface points where the body is cut')
        return frames

    @model_validator(mode="after")
    def _error_of_a_choice(self) -> "CuttableBody":
        if self.geometric_error is not None and self.frames != "auto":
            raise ValueError('`geometric_error` is what frames = "auto" chooses a number for; write that, or leave it out')
        return self

    @model_validator(mode="after")
    def _modes_of_parts(self) -> "CuttableBody":
        if self.modes_per_frame is not None and self.frames == 1:
            raise ValueError(
                "`modes_per_frame` reduces the parts of a body with several `frames`; write these too (frames = [] is one part on a "
                "chord), or reduce the whole body by [basis] in the file that its model is built from"
            )
        return self

    @model_validator(mode="after")
    def _one_turning_frame(self) -> "CuttableBody":
        if self.spin_stiffening and self.parted:
            raise ValueError(
                "`spin_stiffening` is that of a body of one frame; one that is cut stiffens at its cuts: leave it or `frames` out"
            )
        if self.spin_stiffening and not self.turns:
            raise ValueError('`spin_stiffening` is that of a frame that turns; write frame = "moving", or leave it out')
        return self

    def means(self, field: str) -> bool:
        """Whether a field's numbers are numbers of the body, which a wanted error of `frames` is not."""
        return field != "geometric_error" and super().means(field)

    @property
    def dependence(self) -> tuple[str, ...]:
        """Parts of the reduced model that tell how it depends on the parameters; those of the elements too if they make parts."""
        return (*DEPENDENCE, "element_derivatives", "element_affine") if self.parted else DEPENDENCE

    @property
    def parted(self) -> bool:
        """Whether the body has more than one floating frame."""
        return self.frames != 1

    @property
    def choice(self) -> ChosenFrames | None:
        """How the number of frames was chosen in the place of `frames = "auto"`; None of a number that the scene writes."""
        return self._choice

    def as_chosen(self, choice: ChosenFrames | None) -> Self:
        """The same body with the record of a choice of its number of frames."""
        found = self.model_copy()
        found._choice = choice
        return found

    def poses(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Origins (n_t, d) and axes (n_t, d, d) of the frame, from coordinates of the body (n_t, n)."""
        written: Any = self
        origins = q[:, : self.moves] if self.moves else np.tile(np.array(written.position), (len(q), 1))
        if not self.turns:
            return origins, np.tile(written.placement, (len(q), 1, 1))
        return origins, np.stack([self.frame_axes(each) for each in q])

    @abstractmethod
    def frame_axes(self, q: np.ndarray) -> np.ndarray:
        """Rotation matrix (d, d) of a frame that turns, from coordinates of the body (n,)."""
