"""Work of a load or of a driver since the start of the run."""

from __future__ import annotations

from typing import Any

from toolkit.foundation.dimensions import LABELLED, Dimension
from toolkit.foundation.units import unit
from toolkit.responses.balance.power import Doer, Power
from toolkit.responses.over_time.means import Integral


class Work(Doer, Integral):
    """Work of a load or of a driver in the whole run: the integral of its power by the trapezoidal rule."""

    kind = "work"
    quantity = "energy"

    @property
    def source(self) -> Power:
        """Power whose integral over time is this work."""
        return Power(load=self.load, joint=self.joint)

    @property
    def physical_dimension(self) -> Dimension:
        """Physical dimension of an energy."""
        return LABELLED["energy"]

    @property
    def unit_quantity(self) -> str:
        """Name of the physical quantity: "energy"."""
        return "energy"

    def unit(self, system_of_units: str) -> str:
        """Unit of energy in a system of units."""
        return unit(system_of_units, "energy")

    def check(self, scene: Any) -> None:
        """Refuse what the power of the same load or driver refuses."""
        self.source.check(scene)
