r"""Flow without friction around a section: vortex panels of linear strength, with derivatives by contour and angle of attack.

The contour is a streamline: at each of its nodes the stream function is the same number $\psi_0$. With the strengths $\gamma$ of the vortex
sheet at the nodes, which are the speeds of the flow along the contour,

$$\sum_j A_{ij}(z) \, \gamma_j + y_i \cos\alpha - x_i \sin\alpha = \psi_0, \qquad \gamma_1 + \gamma_n = 0$$

in units of the speed far away (Drela, "XFOIL: an analysis and design system for low Reynolds number airfoils", 1989). A blunt tail is
closed by a panel with a source and a vortex sheet of strengths that continue the streamlines of both sides; at a sharp one, whose two
nodes say the same, the strengths go on as a straight line. The error falls with the square of the number of panels.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import lu_factor, lu_solve

from toolkit.air.contour import chord_and_quarter, nose_of, refuse
from toolkit.air.influence import PanelIntegral, Panels, by_nodes, panels_between, source_integral, vortex_integrals
from toolkit.foundation.errors import InputError

SHARP_TAIL_GAP = 1e-4
"""Gap between both sides at the tail, in chords, up to which it is closed by no panel of its own (as in XFOIL)."""
STEP = 1e-30
"""Imaginary part of a complex step: its square is nothing."""


def panels(contour: np.ndarray, *, angle_of_attack: float | complex) -> PanelFlow:
    """Flow without friction around a section.

    Parameters
    ----------
    contour : shape (n, 2), from the tail over the upper side to the nose and back below to the tail, in any unit of length. Its
        points are the ends of the panels, so they have to be closest where the flow turns, at nose and tail.
    angle_of_attack : of the flow against the x axis, in rad

    Raises
    ------
    InputError
        The contour has no such shape, repeats a point, runs the other way round or crosses itself, or the angle is more than a
        right one.
    """
    if not -np.pi / 2 <= np.real(angle_of_attack) <= np.pi / 2:
        raise InputError(
            f"an angle of attack of {np.real(angle_of_attack):.4g} rad is none. Give an angle in rad, up to a right angle."
        )
    nodes = np.asarray(contour)
    nodes = nodes if np.iscomplexobj(nodes) else nodes.astype(float)
    refuse(nodes)
    return PanelFlow(nodes, angle_of_attack)


@dataclass(frozen=True, eq=False)
class PanelFlow:
    """Flow without friction around a section, at an angle of attack; made by `panels`.

    Lengths are those of the contour, speeds are in units of the speed far away, forces in those of the dynamic pressure.
    """

    contour: np.ndarray
    """Ends of the panels, shape (n, 2), from the tail over the upper side and the nose back to the tail."""
    angle_of_attack: float | complex
    """Angle of the flow far away against the x axis, in rad."""

    @cached_property
    def strengths(self) -> np.ndarray:
        """Speed of the flow along the contour at its points, shape (n,): positive on the upper side, negative below."""
        return np.asarray(self._solve(-self._stream(self.angle_of_attack))[:-1])

    @property
    def pressure_coefficient(self) -> np.ndarray:
        """Pressure above that far away at the points of the contour, in dynamic pressures, shape (n,)."""
        return np.asarray(1 - self.strengths**2)

    @property
    def chord(self) -> float | complex:
        """Length from the point farthest in front, of the parabola through three points, to the middle of the tail, along x."""
        return chord_and_quarter(self.contour, self._nose)[0].item()

    @property
    def cl(self) -> float | complex:
        """Lift coefficient, by the circulation."""
        return self._coefficients(self.contour, self.strengths, self.angle_of_attack)[0].item()

    @property
    def cm(self) -> float | complex:
        """Moment coefficient about the quarter of the chord at the height of the tail, positive if it lifts the nose; by the pressure."""
        return self._coefficients(self.contour, self.strengths, self.angle_of_attack)[1].item()

    @property
    def cl_by_pressure(self) -> float | complex:
        """Lift coefficient by the pressure along the contour; its difference to `cl` is an error of the panels."""
        return self._coefficients(self.contour, self.strengths, self.angle_of_attack)[2].item()

    def gradients(self) -> dict[str, tuple[np.ndarray, float | complex]]:
        """Derivatives of `cl` and `cm` by all points of the contour, shape (n, 2), and by the angle of attack.

        Both come from the same factors as the flow (the adjoint way).
        """
        partials = self._partials()
        found = {}
        for name, (by_strengths, by_contour, by_angle) in zip(("cl", "cm"), partials, strict=True):
            adjoint = self._solve(np.append(by_strengths, 0), transposed=True)
            contour = by_contour - np.einsum("i,ijk->jk", adjoint, self.rates_by_contour)
            found[name] = contour, by_angle - adjoint @ self._stream_rate
        return found

    @cached_property
    def rates_by_contour(self) -> np.ndarray:
        """Derivatives of the equations of the flow by the points of the contour at held strengths, shape (n + 1, n, 2)."""
        start, end = self._vortices
        here, there = self.strengths[self._first], self.strengths[self._second]
        sums = PanelIntegral(*(one * here + other * there for one, other in zip(start, end, strict=True)))
        count = len(self.contour)
        found = np.zeros((count + 1, count, 2), dtype=self._matrix.dtype)
        found[:-1] = by_nodes(self._panels, self._first, self._second, sums) / (2 * np.pi)
        nodes = np.arange(count)
        found[nodes, nodes] += [-np.sin(self.angle_of_attack), np.cos(self.angle_of_attack)]
        if self._is_blunt:
            found[:-1] += self._tail_rates()
        else:
            found[count - 1] = 0
        return found

    def _partials(self) -> list[tuple[np.ndarray, np.ndarray, float | complex]]:
        """Derivatives of lift and moment by strengths, by contour and by angle, each at held others: complex steps, all at once."""
        count = len(self.contour)
        nodes = self.contour.real + 1j * STEP * np.eye(2 * count).reshape(2 * count, count, 2)
        speeds = self.strengths.real + 1j * STEP * np.eye(count)
        angle, held = self.angle_of_attack, (self.contour.real, self.strengths.real)
        contour = self._coefficients(nodes, held[1], angle)
        strengths = self._coefficients(held[0], speeds, angle)
        by_angle = self._coefficients(*held, angle + 1j * STEP)
        return [
            (np.imag(strengths[k]) / STEP, (np.imag(contour[k]) / STEP).reshape(count, 2), float(np.imag(by_angle[k]) / STEP))
            for k in range(2)
        ]

    def _coefficients(self, contour: np.ndarray, strengths: np.ndarray, angle: float | complex) -> tuple[np.ndarray, ...]:
        return coefficients(contour, strengths, angle, self._nose, self._is_blunt)

    def _solve(self, right: np.ndarray, transposed: bool = False) -> np.ndarray:
        return np.asarray(lu_solve(self._factors, right, trans=int(transposed)))

    @cached_property
    def _factors(self) -> tuple[np.ndarray, np.ndarray]:
        return lu_factor(self._matrix)

    @cached_property
    def _matrix(self) -> np.ndarray:
        """Equations of the nodes and of the tail, by strengths and stream function of the contour, shape (n + 1, n + 1)."""
        start, end = self._vortices
        count = len(self.contour)
        found = np.zeros((count + 1, count + 1), dtype=np.result_type(self.contour, float))
        found[:-1, : count - 1] = start.value / (2 * np.pi)
        found[:-1, 1:count] += end.value / (2 * np.pi)
        found[:-1, -1] = -1
        found[-1, [0, count - 1]] = 1
        if self._is_blunt:
            tail = self._tail_sums() @ tail_weights(self.contour)
            found[:-1, 0] += tail
            found[:-1, count - 1] -= tail
        else:
            found[count - 1] = 0
            found[count - 1, [0, 1, 2, count - 3, count - 2, count - 1]] = 1, -2, 1, -1, 2, -1
        return found

    def _stream(self, angle: float | complex) -> np.ndarray:
        """Stream function of the undisturbed flow at the nodes, and zero for the tail, shape (n + 1,)."""
        x, y = self.contour.T
        found = np.append(y * np.cos(angle) - x * np.sin(angle), 0)
        if not self._is_blunt:
            found[-2] = 0
        return found

    @property
    def _stream_rate(self) -> np.ndarray:
        """Derivative of `_stream` by the angle, which is the one of a flow turned further by a right angle."""
        return self._stream(self.angle_of_attack + np.pi / 2)

    @cached_property
    def _panels(self) -> Panels:
        return panels_between(self.contour, self._first, self._second)

    @cached_property
    def _tail(self) -> Panels:
        return panels_between(self.contour, *self._tail_ends)

    @cached_property
    def _vortices(self) -> tuple[PanelIntegral, PanelIntegral]:
        return vortex_integrals(self._panels)

    def _tail_sums(self) -> np.ndarray:
        """Stream functions of a vortex sheet and of a source along the tail, both of strength one, shape (n, 2)."""
        start, end = vortex_integrals(self._tail)
        return np.concatenate([start.value + end.value, source_integral(self._tail).value], axis=1) / (2 * np.pi)

    def _tail_rates(self) -> np.ndarray:
        """Share of the tail in `rates_by_contour`, without the row of the tail, shape (n, n, 2)."""
        jump = self.strengths[0] - self.strengths[-1]
        vortex, source = tail_weights(self.contour) * jump
        start, end = vortex_integrals(self._tail)
        parts = zip(start, end, source_integral(self._tail), strict=True)
        sums = PanelIntegral(*((one + other) * vortex + third * source for one, other, third in parts))
        moved = self.contour.real + 1j * STEP * np.eye(2 * len(self.contour)).reshape(-1, *self.contour.shape)
        weights = np.imag(tail_weights(moved)) / STEP * jump
        of_weights = (self._tail_sums() @ weights.T).reshape(len(self.contour), *self.contour.shape)
        return np.asarray(by_nodes(self._tail, *self._tail_ends, sums) / (2 * np.pi) + of_weights)

    @property
    def _first(self) -> np.ndarray:
        return np.arange(len(self.contour) - 1)

    @property
    def _second(self) -> np.ndarray:
        return self._first + 1

    @property
    def _tail_ends(self) -> tuple[np.ndarray, np.ndarray]:
        return np.array([len(self.contour) - 1]), np.array([0])

    @cached_property
    def _is_blunt(self) -> bool:
        gap = np.hypot(*(self.contour[0] - self.contour[-1]).real)
        return bool(gap > SHARP_TAIL_GAP * np.real(self.chord))

    @cached_property
    def _nose(self) -> int:
        return nose_of(self.contour)


def tail_weights(nodes: np.ndarray) -> np.ndarray:
    """Strengths of the vortex sheet and of the source along a blunt tail for a jump of one between the strengths of its two nodes.

    Half a jump is the mean speed of both sides, which leave along the line between them.

    Parameters
    ----------
    nodes : of one contour or of many, shape (..., n, 2)

    Returns
    -------
    of shape (..., 2)
    """
    upper, lower, across = (
        nodes[..., 0, :] - nodes[..., 1, :],
        nodes[..., -1, :] - nodes[..., -2, :],
        nodes[..., 0, :] - nodes[..., -1, :],
    )
    away = _unit(_unit(upper) + _unit(lower))
    across = _unit(across)
    along = (away * across).sum(axis=-1)
    return np.stack([-along / 2, (away[..., 0] * across[..., 1] - away[..., 1] * across[..., 0]) / 2], axis=-1)


def coefficients(
    nodes: np.ndarray, strengths: np.ndarray, angle: float | complex, nose: int, is_blunt: bool
) -> tuple[np.ndarray, ...]:
    """Coefficients of lift by the circulation, of moment, and of lift by the pressure, of one contour or of many.

    Parameters
    ----------
    nodes : shape (..., n, 2)
    strengths : shape (..., n)
    angle : of attack
    nose : number of the point farthest in front
    is_blunt : whether a panel closes the tail
    """
    chord, quarter = chord_and_quarter(nodes, nose)
    spans = np.diff(nodes, axis=-2)
    lengths = np.sqrt((spans**2).sum(axis=-1))
    circulation = (lengths * (strengths[..., :-1] + strengths[..., 1:])).sum(axis=-1) / 2
    if is_blunt:
        gap = np.sqrt(((nodes[..., 0, :] - nodes[..., -1, :]) ** 2).sum(axis=-1))
        circulation = circulation + tail_weights(nodes)[..., 0] * (strengths[..., 0] - strengths[..., -1]) * gap
    force, moment = _force_and_moment(nodes, strengths, quarter)
    lift = force[..., 1] * np.cos(angle) - force[..., 0] * np.sin(angle)
    return 2 * circulation / chord, moment / chord**2, lift / chord


def _force_and_moment(nodes: np.ndarray, strengths: np.ndarray, about: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Force of the pressure on the closed contour, and its moment that lifts the nose, in dynamic pressures.

    The square of a speed that is linear is integrated exactly, by Simpson's rule.
    """
    ends, there = np.roll(nodes, -1, axis=-2), np.concatenate([strengths[..., 1:], strengths[..., -1:]], axis=-1)
    spans = ends - nodes
    force, moment = 0, 0
    for share, along in ((1 / 6, 0.0), (4 / 6, 0.5), (1 / 6, 1.0)):
        pressure = 1 - ((1 - along) * strengths + along * there) ** 2
        push = share * pressure[..., None] * np.stack([-spans[..., 1], spans[..., 0]], axis=-1)
        arm = nodes + along * spans - about[..., None, :]
        force = force + push.sum(axis=-2)
        moment = moment + (arm[..., 1] * push[..., 0] - arm[..., 0] * push[..., 1]).sum(axis=-1)
    return np.asarray(force), np.asarray(moment)


def _unit(vector: np.ndarray) -> np.ndarray:
    return np.asarray(vector / np.sqrt((vector**2).sum(axis=-1, keepdims=True)))
