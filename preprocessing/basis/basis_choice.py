"""What a person chooses of a reduction basis: its kind, its number of modes, and whether it follows the design."""

from __future__ import annotations

from dataclasses import dataclass

from toolkit.foundation.errors import InputError

KINDS = ("full", "eigenmodes", "craig-bampton", "static")
BOUNDARIES = ("clamped", "free")
DERIVATIVES = ("differentiated", "frozen")
WAYS = ("count", "frequency", "static_error")
_WAYS_OF_KIND = {"full": (), "static": (), "eigenmodes": WAYS, "craig-bampton": ("count", "frequency")}
_WHY_NOT = {
    "full": "the full basis keeps every coordinate",
    "static": "a static basis has no eigenmodes",
    "craig-bampton": "a Craig-Bampton basis is statically exact at its interface points with any number of modes",
    "eigenmodes": "",
}


@dataclass(frozen=True)
class BasisChoice:
    """Choice of a basis before it is computed; `count`, `frequency` and `static_error` are three ways to set how many modes."""

    kind: str
    boundary: str = "clamped"  # of eigenmodes: held with the body's frame, or free about mean axes
    count: int | None = None
    frequency: float | None = None  # highest, in Hz
    static_error: float | None = None  # relative error of the compliance at the interface points
    derivative: str = "differentiated"  # or "frozen": the shapes stay what they are when the design changes
    chord: tuple[str, ...] | None = None  # two interface points that the body's frame goes through, instead of a clamp
    spin_stiffening: bool = False  # whether the model tells how a spin of its frame stiffens the body
    beside_frozen: bool = (
        False  # whether it stands beside a frozen one, without elements and with all modes where `count` is more than these
    )

    @property
    def followed(self) -> tuple[str, ...] | None:
        """Interface points whose places the shapes follow; None for all of them."""
        if self.derivative != "differentiated":
            return ()
        return None if self.kind in ("craig-bampton", "static") else tuple(self.chord or ())

    def __post_init__(self) -> None:
        for name, allowed in (("kind", KINDS), ("boundary", BOUNDARIES), ("derivative", DERIVATIVES)):
            if getattr(self, name) not in allowed:
                raise InputError(f"{name} {getattr(self, name)!r} is unknown; available: {', '.join(allowed)}.")
        if self.boundary == "free" and self.kind != "eigenmodes":
            raise InputError(f'boundary "free" belongs to eigenmodes; a {self.kind} basis is clamped. Leave the key out.')
        self._check_chord()
        self._check_number_of_modes()

    def _check_chord(self) -> None:
        if self.chord is None:
            return
        if len(self.chord) != 2 or self.chord[0] == self.chord[1]:
            raise InputError(
                f"chord goes through two interface points; got {', '.join(self.chord) or 'none'}. Name two different ones."
            )
        if self.spin_stiffening:
            raise InputError(
                "spin_stiffening is that of a body whose frame is clamped, or floats about mean axes; a chord turns as the body "
                "bends. Give the frame a clamp, or leave one of them out."
            )
        if self.boundary == "free":
            raise InputError(
                'boundary "free" floats about mean axes, and a chord holds the frame at two points. Leave one of them out.'
            )

    def _check_number_of_modes(self) -> None:
        ways = _WAYS_OF_KIND[self.kind]
        given = [way for way in WAYS if getattr(self, way) is not None]
        if foreign := [way for way in given if way not in ways]:
            remedy = f"Give {' or '.join(ways)}" if ways else "Leave the key out"
            raise InputError(f"{', '.join(foreign)} does not fit to {self.kind}: {_WHY_NOT[self.kind]}. {remedy}.")
        if ways and len(given) != 1:
            raise InputError(f"{self.kind} needs exactly one of {', '.join(ways)}; got {', '.join(given) or 'none'}.")
        least = 1 if self.kind == "eigenmodes" else 0
        if self.count is not None and self.count < least:
            raise InputError(f"count {self.count} is invalid; {self.kind} needs at least {least}.")
