"""N four-bar linkages in a row (IFToMM problem A02): rigid bars that turn through singular positions."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import exudyn
import numpy as np
from exudyn import itemInterface as items
from scipy.integrate import solve_ivp

from tests.benchmarks.peers import exudyn_runs, our_runs
from tests.benchmarks.peers.contest import Contest
from tests.models.four_bars import four_bars

END_TIME, STEP, RHO_INF = 4.0, 1e-3, 0.8
GRAVITY = 9.81


def contest(count: int) -> Contest:
    """The angle of the first bar after 4 s."""
    dense = ("EigenDense",) if count < 20 else ()
    return Contest(
        name=f"four-bar linkages, N = {count}",
        quantity="angle, rad",
        end_time=END_TIME,
        step=STEP,
        ours=our_runs.makers(four_bars(count), END_TIME, RHO_INF, lambda run: -run.solution.q[-1, [2]]),
        exudyn=exudyn_runs.makers(lambda: in_exudyn(count), END_TIME, RHO_INF, (*dense, "EigenSparse")),
        exact=exact_angle(count),
    )


def exact_angle(count: int) -> np.ndarray:
    """All bars turn as one pendulum: ((N + 1) / 3 + N) phi'' = ((N + 1) / 2 + N) g sin(phi), integrated to twelve digits."""
    ratio = ((count + 1) / 2 + count) / ((count + 1) / 3 + count) * GRAVITY
    path = solve_ivp(lambda _, y: [y[1], ratio * np.sin(y[0])], (0.0, END_TIME), [0.0, 1.0], "DOP853", rtol=1e-12, atol=1e-12)
    return path.y[:1, -1]


def in_exudyn(count: int) -> tuple[Any, Callable[[], np.ndarray]]:
    """The same bars between the same joints."""
    container = exudyn.SystemContainer()
    system = container.AddSystem()
    ground = system.AddObject(items.ObjectGround())

    def bar(place: list[float], velocity: list[float]) -> tuple[int, int]:
        node = system.AddNode(items.NodeRigidBody2D(referenceCoordinates=place, initialVelocities=velocity))
        body = system.AddObject(items.ObjectRigidBody2D(mass=1.0, inertia=1 / 12, nodeNumber=node))
        marker = system.AddMarker(items.MarkerBodyMass(bodyNumber=body))
        system.AddLoad(items.LoadMassProportional(markerNumber=marker, loadVector=[0.0, -GRAVITY, 0.0]))
        return node, body

    def joint(*ends: tuple[int, float]) -> None:
        markers = [system.AddMarker(items.MarkerBodyPosition(bodyNumber=body, localPosition=[x, 0.0, 0.0])) for body, x in ends]
        system.AddObject(items.ObjectJointRevolute2D(markerNumbers=markers))

    links = [bar([float(i), 0.5, np.pi / 2], [0.5, 0.0, -1.0]) for i in range(count + 1)]
    couplers = [bar([i - 0.5, 1.0, 0.0], [1.0, 0.0, 0.0]) for i in range(1, count + 1)]
    for i, (_, link) in enumerate(links):
        joint((ground, float(i)), (link, -0.5))
    for i, (_, coupler) in enumerate(couplers):
        joint((links[i][1], 0.5), (coupler, -0.5))
        joint((links[i + 1][1], 0.5), (coupler, 0.5))
    system.Assemble()

    def angle() -> np.ndarray:
        assert container is not None  # owns the system
        return -np.array(system.GetNodeOutput(links[0][0], exudyn.OutputVariableType.Coordinates)[2:])

    return system, angle
