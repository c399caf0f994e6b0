"""All built-in responses: importing this file makes them known to scene files."""

from toolkit.responses.response import Response

__all__ = ["Response"]
