"""Where rates mean something: not in a run without inertia."""

from __future__ import annotations

from typing import Any

from toolkit.foundation.errors import InputError
from toolkit.responses.instant import Instant


class OfRates(Instant):
    """Base of responses that are made of velocities or accelerations."""

    @property
    def needs_motion(self) -> bool:
        """Whether the response exists for a transient solution only: always true, as rates are zero at rest."""
        return True

    def check(self, scene: Any) -> None:
        """Refuse rates in a quasi-static run, whose velocities are those between one equilibrium and the next.

        Raises
        ------
        InputError
            Says what can be asked for instead.
        """
        super().check(scene)
        if scene.solver.quasi_static:
            raise InputError(
                f"a quasi-static run (solver.quasi_static) knows no {self.kind}: it goes from one equilibrium to the next, and its "
                "velocities are those between them. Ask for places and angles, or run with inertia."
            )
