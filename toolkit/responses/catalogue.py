"""All built-in responses; importing this file makes them known to scene files."""

from toolkit.description.description import import_room
from toolkit.responses.response import Response

__all__ = ["Response"]

import_room("toolkit.responses")
