"""Stress of flexible bodies: the field over all points and times, its maximum, and the smooth maximum.

One stress for every stress point: that of a fibre, or von Mises' equivalent stress of six components.

With the components s = (xx, yy, zz, yz, xz, xy)

    sigma_vM^2 = s^T V s = ((xx - yy)^2 + (yy - zz)^2 + (zz - xx)^2) / 2 + 3 (yz^2 + xz^2 + xy^2)
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np
import scipy

from toolkit.components.bodies.cut_body import CutBody
from toolkit.components.bodies.model_body import DEPENDENCE
from toolkit.description.description import Positive, Quantity
from toolkit.description.design import BodyPoint
from toolkit.foundation.near_ties import RESULT_TIE_BAND, first_largest
from toolkit.reduced_model.dependence import SEARCHED_ARRAY_SIZE, Derivatives
from toolkit.reduced_model.design_point import NONE, rates_at
from toolkit.reduced_model.model import place_parameter
from toolkit.responses.response import Partials, Response, felt_steps
from toolkit.scene.resolution import ResolvedScene
from toolkit.scene.scene import Scene
from toolkit.system.quantities import STEP
from toolkit.system.solution import Solution, design_point, elastic_coordinates, flexible_body

if TYPE_CHECKING:
    from toolkit.foundation.value_types import Matrix


def kreisselmeier_steinhauser(values: np.ndarray, aggregation: float) -> tuple[complex, np.ndarray]:
    """Smooth maximum and its derivative by every value, safe from overflow (paper, eqs. 47 and 51).

        KS = m + ln(sum_k exp(rho (g_k - m))) / rho,    m = max g,    dKS/dg_k = exp(rho (g_k - KS))

    with rho = `aggregation`, in 1/unit of the values. max g <= KS <= max g + ln(n) / rho.

    Returns
    -------
    value : float or complex
    weights : array
        Of the values' shape; they sum to one.
    """
    largest = values.flat[np.argmax(values.real)].real
    parts = np.exp(aggregation * (values - largest))
    total = parts.sum()
    return largest + np.log(total) / aggregation, parts / total


def gap_bound(count: int, aggregation: float) -> float:
    """Most that KS can exceed the true maximum of `count` values: ln(n) / rho."""
    return float(np.log(count) / aggregation)


V = np.zeros((6, 6))
V[:3, :3] = 1.5 * np.eye(3) - 0.5
V[3:, 3:] = 3 * np.eye(3)


def point_stress(components: np.ndarray) -> np.ndarray:
    """Stress of every point (...,) from its components (..., 1 or 6); complex-safe."""
    if components.shape[-1] == 1:
        return components[..., 0]
    xx, yy, zz, yz, xz, xy = np.moveaxis(components, -1, 0)
    return np.sqrt(((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) / 2 + 3 * (yz**2 + xz**2 + xy**2))


def point_slope(components: np.ndarray) -> np.ndarray:
    """Derivative of `point_stress` by the components, of the same shape; zero where there is no stress, and so no direction."""
    if components.shape[-1] == 1:
        return np.ones(components.shape)
    stress = point_stress(components)[..., None]
    return np.divide(components @ V, stress, out=np.zeros(components.shape, components.dtype), where=stress != 0)


MOST_KEPT_STRESSES = 1_000_000
"""Components of stress up to which a solution keeps them for its next response."""


def stress_operator(scene: ResolvedScene, body: str) -> np.ndarray:
    """Components of stress per elastic coordinate at the scene's parameter values, shape (n_s, 1 or 6, n_f)."""
    operator = flexible_body(scene, body).stress_operator(scene)
    return operator[:, None] if operator.ndim == 2 else operator


def stress_components(scene: ResolvedScene, body: str, q_f: np.ndarray) -> np.ndarray:
    """Components of stress (..., n_s, 1 or 6) at elastic coordinates (..., n_f)."""
    found = by_instant(q_f.reshape(-1, q_f.shape[-1]), stress_rows(scene, body).T)
    points, *components, _ = design_point(scene, body).model.invariants.stress_operator.shape
    return found.reshape(*q_f.shape[:-1], points, *(components or [1]))


def stress_rows(scene: ResolvedScene, body: str) -> Matrix:
    """Stress operator as a matrix (n_s times components, n_f); sparse if it is large and zero nearly everywhere."""
    if isinstance(scene.bodies.get(body), CutBody):
        operator = flexible_body(scene, body).stress_operator(scene)
        return operator.reshape(-1, operator.shape[-1])
    return design_point(scene, body).rows("stress_operator")


def by_instant(states: np.ndarray, matrix: Matrix) -> np.ndarray:
    """Products of states (n_t, k) and a matrix (k, m), dense or sparse, one state at a time.

    A product of all states at once would round each by how many there are.

    Stress is a difference of large displacements, and a smooth maximum multiplies the last digits of that difference by its exponent: so
    those of a window must be those of the whole run.
    """
    if isinstance(matrix, np.ndarray):
        found: np.ndarray = np.matmul(states[:, None], matrix)[:, 0]  # for which numpy calls BLAS for one state after the other
        return found
    return np.stack([state @ matrix for state in states]) if len(states) else states @ matrix


def products(one: np.ndarray, other: np.ndarray, entry: np.ndarray) -> np.ndarray:
    """Entries of the flattened one^T other for one (n_t, m) and other (n_t, n): together, or of a large product one by one."""
    if one.shape[1] * other.shape[1] < SEARCHED_ARRAY_SIZE:
        return (one.T @ other).ravel()[entry]
    place, number = np.unique(entry, return_inverse=True)
    row, column = np.divmod(place, other.shape[1])
    found = np.zeros(len(place), np.result_type(one, other))
    for left, right in zip(one, other, strict=True):
        found += left[row] * right[column]
    return found[number]


def design_rates(solution: Solution, body: str, item: str, *parts: str) -> Derivatives:
    """Derivatives of an array of a body's reduced model by the design variables, numbered as these are."""
    found: Derivatives = solution.system.scene.once(
        ("rates", body, item, *solution.system.design.names), lambda: _rates(solution, body, item, *parts)
    )
    return found


def _rates(solution: Solution, body: str, item: str, *parts: str) -> Derivatives:
    scene = solution.system.scene
    driven = [
        (model_parameter(scene, body, path), x, factor)
        for x, variable in enumerate(solution.system.design)
        for path, factor in zip(variable.paths, variable.factors, strict=True)
    ]
    names = {name: k for k, (name, _, _) in enumerate(driven)}
    if not any(name in scene.model(flexible_body(scene, body).model).nominal for name in names):
        return NONE
    if item == "stress_operator" and isinstance(scene.bodies.get(body), CutBody):
        return _rates_by_steps(solution, body)
    found = rates_at(design_point(scene, body, *DEPENDENCE, *parts), item, names)
    columns, factors = (np.array(each) for each in zip(*(numbers for _, *numbers in driven), strict=True))
    return Derivatives(columns[found.parameter], found.entry, factors[found.parameter] * found.value)


def _rates_by_steps(solution: Solution, body: str) -> Derivatives:
    """Derivatives of a cut body's stress operator by complex steps in the parameters; its chords turn with its nodes."""
    scene, found = solution.system.scene, [NONE]
    for x, variable in enumerate(solution.system.design):
        if any(model_parameter(scene, body, path) for path in variable.paths):
            change = np.imag(stress_operator(scene.moved(variable, 1j * STEP), body)).ravel() / STEP
            entry = np.flatnonzero(change)
            found.append(Derivatives(np.full(len(entry), x), entry, change[entry]))
    return sum(found[1:], found[0])


def model_parameter(scene: Scene, body: str, path: str) -> str:
    """Name of the parameter of a body's reduced model that the number at a path may be; empty if it is none."""
    group, name, *rest = path.split(".")
    if group == "bodies" and name == body:
        return ".".join(rest)
    point = scene.points[name] if group == "points" and rest == ["arc_length"] else None
    return place_parameter(point.interface) if isinstance(point, BodyPoint) and point.body == body else ""


def stress_field(solution: Solution, body: str) -> tuple[np.ndarray, np.ndarray]:
    """Stress at every point and time (n_t, n_s), and its design derivatives (n_t, n_s, n_x); components are B q_f, with B dq_f + dB q_f."""
    scene, q = solution.system.scene, solution.q[:, elastic_coordinates(solution, body)]
    operator, components = stress_operator(scene, body), stress_components(scene, body, q)
    flat = operator.reshape(-1, operator.shape[-1])
    derivative = np.einsum("sf,tfx->tsx", flat, solution.dq[:, elastic_coordinates(solution, body)])
    rates = design_rates(solution, body, "stress_operator")
    for x in np.unique(rates.parameter):
        entry, value = rates.by(x)
        change = scipy.sparse.coo_array((value, np.unravel_index(entry, flat.shape)), flat.shape).tocsr()
        derivative[:, :, x] += np.real(q @ change.T)
    slope = np.real(point_slope(components))
    return point_stress(components), np.einsum("tsc,tscx->tsx", slope, derivative.reshape(*components.shape, -1))


class StressResponse(Response):
    """Base of responses that weight the stress of all points and times.

    Attributes
    ----------
    body
        Name of a flexible body.
    measure
        Signed: tension counts. Absolute: tension and compression count alike. The stress of solids is von Mises', which has no sign.
    when
        All times, or the end.
    """

    quantity = "stress"

    body: str
    measure: Literal["signed", "absolute"] = "signed"
    when: Literal["all", "end"] = "all"

    def check(self, scene: ResolvedScene) -> None:
        """Refuse a body that is not flexible."""
        flexible_body(scene, self.body)

    def considered(self, solution: Solution) -> np.ndarray:
        """Stress values that count, shape (n_t, n_s), or (n_t, 2 n_s) with the opposite sign too."""
        known, key = solution.known, (StressResponse.considered, self.body, self.when, self.measure)
        if key in known:
            kept: np.ndarray = known[key]
            return kept
        found = self.signed(self.components(solution))
        if found.size <= MOST_KEPT_STRESSES:
            known[key] = found
        return found

    def signed(self, components: np.ndarray) -> np.ndarray:
        """Stress values that count, (n_t, n_s) or (n_t, 2 n_s), from the given stress components."""
        stress = point_stress(components)
        return np.hstack([stress, -stress]) if self.twice(components) else stress

    def components(self, solution: Solution) -> np.ndarray:
        """Components of stress at the times that count, (n_t, n_s, 1 or 6)."""
        known, key = solution.known, (StressResponse, self.body, self.when)
        if key in known:
            kept: np.ndarray = known[key]
            return kept
        where = elastic_coordinates(solution, self.body)
        q = solution.q[:, where] if self.when == "all" else solution.q[-1:, where]
        found = stress_components(solution.system.scene, self.body, q)
        if found.size <= MOST_KEPT_STRESSES:
            known[key] = found
        return found

    def twice(self, components: np.ndarray) -> bool:
        """Whether the opposite sign counts too."""
        return self.measure == "absolute" and components.shape[-1] == 1

    def chain(self, solution: Solution, components: np.ndarray, value: complex, weights: np.ndarray) -> Partials:
        """Value and partial derivatives from the stress components that count and the derivatives by the considered values."""
        weights = np.real(weights)
        if self.twice(components):
            weights = weights[:, : weights.shape[1] // 2] - weights[:, weights.shape[1] // 2 :]
        by_component = (weights[..., None] * np.real(point_slope(components))).reshape(len(components), -1)
        if self.when == "end":
            by_component = np.vstack([np.zeros((len(solution.times) - 1, by_component.shape[1])), by_component])
        felt, where = felt_steps(by_component), elastic_coordinates(solution, self.body)
        by_component, q = by_component[felt], solution.q[:, where]
        by_q, value_q = np.zeros(q.shape), np.zeros(solution.q.shape)
        by_q[felt] = by_instant(by_component, stress_rows(solution.system.scene, self.body).real)
        value_q[:, where] = by_q
        rates = design_rates(solution, self.body, "stress_operator")
        by_operator = np.real(products(by_component, q[felt], rates.entry))
        design = np.bincount(rates.parameter, by_operator * rates.value, solution.system.n_x)
        return Partials(value, q=value_q, design=design)


class KSStress(StressResponse):
    """Smooth maximum of the stress (paper, eq. 47) over all points and times.

    A value of `aggregation` that is right for MPa is wrong for Pa, unless it is a pure number because of a `reference_stress`.

    Attributes
    ----------
    aggregation
        Parameter rho, in 1/unit of stress, or a pure number with `reference_stress`.
    reference_stress
        Stress that all stresses are divided by first; the result is a stress again.
    """

    kind = "ks-stress"

    aggregation: Positive
    reference_stress: Annotated[Positive | None, Quantity("stress")] = None

    def quantity_of(self, field: str) -> Quantity | None:
        """Quantity of a field: the aggregation's is 1/stress, or a pure number where there is a reference stress."""
        if field == "aggregation":
            return Quantity("1/stress" if self.reference_stress is None else "none")
        return super().quantity_of(field)

    @property
    def sharpness(self) -> float:
        """Aggregation parameter in 1/unit of stress."""
        return self.aggregation / (1.0 if self.reference_stress is None else self.reference_stress)

    def partials(self, solution: Solution) -> Partials:
        """Smooth maximum and its partial derivatives, by softmax weights of all stresses."""
        components = self.components(solution)
        return self.chain(solution, components, *kreisselmeier_steinhauser(self.considered(solution), self.sharpness))

    def remark(self, solution: Solution) -> str:
        """Words on how far the smooth maximum exceeds the true one, and how far it could."""
        stress = self.considered(solution)
        gap = np.real(kreisselmeier_steinhauser(stress, self.sharpness)[0]) - stress.real.max()
        return f"exceeds the true maximum by {gap:.3g}, at most ln(n)/rho = {gap_bound(stress.size, self.sharpness):.3g}"


class MaxStress(StressResponse):
    """Largest stress over all points and times; its derivative is that of the point and time where it occurs."""

    kind = "max-stress"

    def partials(self, solution: Solution) -> Partials:
        """Largest stress and its partial derivatives: those of the stress at the first place where it occurs."""
        components = self.components(solution)
        stress = self.considered(solution)
        weights = np.zeros(stress.shape)
        place = np.unravel_index(first_largest(stress.real.ravel(), RESULT_TIE_BAND), stress.shape)
        weights[place] = 1
        return self.chain(solution, components, stress[place], weights)
