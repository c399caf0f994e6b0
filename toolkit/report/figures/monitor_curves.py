"""Energy and constraint drift over time."""

from __future__ import annotations

import numpy as np

from toolkit.foundation.units import unit
from toolkit.render.curves import merged, told
from toolkit.render.readable_units import readable
from toolkit.render.sheet import sheet, style
from toolkit.report.drawing import Drawing
from toolkit.report.material import Material


def monitor_curves(material: Material) -> list[Drawing]:
    """Energies, what the balance lacks, and the largest violation of any joint."""
    if not material.moving:
        return []
    found, times, energy = material.monitors, material.solution.times, unit(material.scene.units, "energy")
    curves = merged(told({"kinetic": found.energy.kinetic, "strain": found.energy.strain, "work": found.energy.work}))
    with sheet(7.2, 3, sharex=True) as (figure, axes):
        above, balance, below = axes[:, 0]
        factor, label = readable(max(float(np.abs(values).max()) for values in curves.values()), energy)
        for number, (name, values) in enumerate(curves.items()):
            above.plot(times, factor * values, label=name, **style(number))
        above.set_ylabel(f"energy in {label}")
        above.update_datalim([(times[0], 0.0)])  # beside zero a change is seen as large as it is
        above.autoscale_view()
        above.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=3)
        factor, label = readable(float(np.abs(found.energy.defect).max()), energy)
        balance.plot(times, factor * found.energy.defect, **style(4))
        balance.set_ylabel(f"defect in {label}")
        balance.set_title("energy gained minus work of loads, drivers and dampers", loc="left")
        tolerance = material.scene.solver.drift_tolerance
        below.semilogy(times, np.where(found.drift > 0, found.drift, np.nan), **style(0))
        below.axhline(tolerance, color="black", linewidth=1, linestyle=":")
        below.annotate("limit of the run", (times[-1], tolerance), (0, -3), textcoords="offset points", ha="right", va="top")
        below.set_ylabel("relative drift")
        below.set_title("largest opening of a joint, relative to the scene's size", loc="left")
        below.set_xlabel(f"time in {unit(material.scene.units, 'time')}")
    caption = (
        "The defect of the energy balance is what the time scheme created (or took, negative), and the error of the sum over time steps. "
        "Drift is what the stabilisation leaves."
    )
    return [Drawing("monitors", "Energy and constraint drift", caption, figure)]
