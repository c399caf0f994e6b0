"""Choice of a number of floating frames by runs of the scene, and what it was chosen by."""

from __future__ import annotations

from typing import NamedTuple


class FrameChoice(NamedTuple):
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
