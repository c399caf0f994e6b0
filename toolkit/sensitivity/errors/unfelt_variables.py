"""Variables that nothing which is asked for feels."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from toolkit.foundation.verdict import Caution

MOST = 5
"""So many are named at the most."""
MISSING_STIFFNESS = ("tension", "critical-load")
"""Doubts which say that forces along a body should change what they do not change here: zeros may be wrong."""


def unfelt_variables(gradients: Mapping[str, Mapping[str, float]]) -> Iterator[Caution]:
    """The remark that all derivatives by some variables are exactly zero: rightly so, or because another number was meant.

    Parameters
    ----------
    gradients : dict
        Response -> variable -> derivative.
    """
    variables = next(iter(gradients.values()), {})
    unfelt = [x for x in variables if all(slopes[x] == 0 for slopes in gradients.values())]
    if unfelt:
        named = ", ".join(unfelt[:MOST]) + (f" and {len(unfelt) - MOST} more" if len(unfelt) > MOST else "")
        yield Caution(
            "unfelt",
            f"no response changes with {named}: all derivatives by {'them' if len(unfelt) > 1 else 'it'} are zero. That is right where "
            "nothing asked for depends on such a number, as equilibria without weight do not on densities; otherwise name another one.",
            doubt=False,
        )


def without_false_zeros(cautions: Sequence[Caution]) -> list[Caution]:
    """The same without the remark that zeros may be right, where a doubt says that they are not."""
    missing = any(each.doubt and each.code in MISSING_STIFFNESS for each in cautions)
    return [each for each in cautions if not (missing and each.code == "unfelt")]
