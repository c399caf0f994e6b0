"""The air around a section: flow without friction by panels of vortices, with derivatives by the contour.

`ffrf.air.panels` is the flow around a contour alone, without a scene.
"""

from toolkit.air.contour import with_flap
from toolkit.air.panels import PanelFlow, panels

__all__ = ["PanelFlow", "panels", "with_flap"]
