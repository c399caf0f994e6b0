"""All figures in the order of the report."""

from __future__ import annotations

from collections.abc import Callable

from toolkit.report.drawing import Drawing
from toolkit.report.figures.certificate import certificate
from toolkit.report.figures.error_sensitivity import error_sensitivity
from toolkit.report.figures.load_curves import load_curves
from toolkit.report.figures.mechanism import mechanism
from toolkit.report.figures.monitor_curves import monitor_curves
from toolkit.report.figures.skin_error import skin_error
from toolkit.report.figures.stress_motion import stress_motion
from toolkit.report.figures.stress_sensitivity import stress_sensitivity
from toolkit.report.material import Material
from toolkit.scene.space import PLANE, SPACE, Space

Figure = Callable[[Material], list[Drawing]]
FIGURES: tuple[Figure, ...] = (
    stress_motion,
    load_curves,
    mechanism,
    skin_error,
    stress_sensitivity,
    error_sensitivity,
    certificate,
    monitor_curves,
)
"""Of scenes in the plane."""
FIGURES_IN: dict[Space, tuple[Figure, ...]] = {PLANE: FIGURES, SPACE: (load_curves, certificate, monitor_curves)}
"""Those of scenes in space look at no body; pictures of bodies come from `motion`."""
