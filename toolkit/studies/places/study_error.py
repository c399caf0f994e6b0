"""What ends the work of a study from outside."""

from __future__ import annotations

from toolkit.foundation.errors import ToolkitError


class StudyError(ToolkitError, RuntimeError):
    """A process, a worker or a cluster of a study ended without a word."""
