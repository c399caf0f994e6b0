"""The errors that a user of the toolkit can meet, each with what, where, what would be right and the next step."""


class ToolkitError(Exception):
    """Base of every error that the toolkit raises on purpose; the command line prints its text without a traceback."""


class InputError(ToolkitError, ValueError):
    """What the user wrote cannot be meant: a scene, a path, a number, an option."""


class NeedsDirectError(InputError):
    """The adjoint lacks derivatives of the states that direct differentiation has; `why` says which."""

    def __init__(self, why: str) -> None:
        super().__init__(f"{why}. Use the direct method.")
        self.why = why


class ModelFileError(ToolkitError, ValueError):
    """A reduced-model file is missing, damaged, foreign or of another schema version."""


class SingularSystemError(ToolkitError, ArithmeticError):
    """The equations have no unique solution: a free mechanism in statics, redundant or contradictory joints."""


class ConvergenceError(ToolkitError, ArithmeticError):
    """Newton's iteration stopped before it met its criterion."""


class ConformanceError(ToolkitError, ArithmeticError):
    """A component states a derivative that is not the derivative of its own law."""
