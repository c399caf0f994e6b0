"""All built-in time curves; importing this file makes them known to scene files."""

from toolkit.components.curves.curve import Curve
from toolkit.description.description import import_room

__all__ = ["Curve"]

import_room("toolkit.components.curves")
