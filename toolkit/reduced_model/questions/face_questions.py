"""What the faces between the pieces of a solid do to its displacements: what its preprocessing has found out, in words."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from toolkit.foundation.verdict import Caution
from toolkit.reduced_model.model import ReducedModel

EXTREMES = ("least", "largest")
"""Names among `ReducedModel.face_errors` of those under any forces and moments at once; all others are of one force or moment each."""
LIMIT = 0.05
"""Error of displacements above which faces are questioned."""


def told_faces(model: ReducedModel) -> str:
    """Errors of the faces between pieces in a sentence; empty of a body that is not in pieces."""
    if not model.face_errors:
        return ""
    least, largest = (model.face_errors[name] for name in EXTREMES)
    single = {name: error for name, error in model.face_errors.items() if name not in EXTREMES}
    worst = max(single, key=lambda name: abs(single[name]))
    return (
        f"faces between pieces change displacements by {100 * least:+.2g} to {100 * largest:+.2g} % under forces and moments at the "
        f"interface points (most by a {worst}: {100 * single[worst]:+.2g} %)"
    )


def face_record(model: ReducedModel) -> dict[str, Any] | None:
    """Errors of the faces between pieces as numbers with their meanings, for JSON; None of a body that is not in pieces."""
    if not model.face_errors:
        return None
    return {
        "told": told_faces(model),
        "measure": "error of the displacements by the faces between pieces, in parts of those of the uncut mesh",
        "cases": dict(model.face_errors),
    }


def face_questions(model: ReducedModel, where: str, doubt: bool = False) -> Iterator[Caution]:
    """Caution about faces between pieces whose error is too large."""
    if max((abs(error) for error in model.face_errors.values()), default=0.0) > LIMIT:
        yield Caution(
            "faces-of-pieces",
            f"{where}: {told_faces(model)}: more than {LIMIT:.0%}. Cut it into fewer or longer pieces; those with averaged and with rigid "
            "faces have the truth between them.",
            doubt,
        )
