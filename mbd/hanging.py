"""The container beside its vertical motion on ropes: swinging below a trolley at rest, and standing on the ground.

Pendulum: with L the free length of the rigidly rolling train, e the vertical stretch row and (X, Y) the sway,

    d = sqrt((L + e)^2 + X^2 + Y^2)      s = d - L      F = max(0, k s + c s'),   k = EA/L per drum

pulls along the ropes; U = k s^2/2. No approximation of small angles. s is formed as (d^2 - L^2)/(d + L): the difference
of metres would leave 1e-15 m, 2e-12 of a light weight, on which the search for the equilibrium stalls. The rate s'
leaves out the part of L', which is (1 - cos of the angle) times the rope speed. Winding at constant speed changes L
slowly: the sway angle then grows as L^(-3/4) (adiabatic invariant E/omega of the pendulum).

Ground: with the height g of the ground and the lift z of the container, both over the place where the just taut rope
holds it at t = 0, F = max(0, k s + c s') for s = g - z > 0. It pushes upwards only; nothing moves along it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from fem.compiled import inner
from mbd.checks import finite, not_negative, positive


@dataclass(frozen=True, kw_only=True)
class Ground:
    """Ground under the container: ``level`` (m) over the place of the just taut rope, N/m, damping ratio of the
    container on it."""

    level: float
    stiffness: float
    damping_ratio: float = 0.1

    def __post_init__(self) -> None:
        finite("ground level", self.level)
        positive("ground stiffness", self.stiffness)
        not_negative("ground damping_ratio", self.damping_ratio)


@inner()
def rope_pull(values, angle, u, v, force, stiff, loss):
    """Forces (3,) on (stretch, X, Y) times -1, tangents by u and v (3, 3); elastic force, potential U, lost power,
    dU/d angle at fixed u."""
    length = values[1] - values[2] * angle
    k = values[0] / length
    c = values[3] * math.sqrt(k)
    depth = length + u[0]
    distance = math.sqrt(depth * depth + u[1] * u[1] + u[2] * u[2])
    s = (u[0] * (depth + length) + u[1] * u[1] + u[2] * u[2]) / (distance + length)  # d - L without its cancellation
    for i in range(3):
        force[i] = 0.0
        for j in range(3):
            stiff[i, j] = 0.0
            loss[i, j] = 0.0
    if s <= 0.0:
        return 0.0, 0.0, 0.0, 0.0
    n = (depth / distance, u[1] / distance, u[2] / distance)
    rate = n[0] * v[0] + n[1] * v[1] + n[2] * v[2]
    elastic = k * s
    total = elastic + c * rate
    if total <= 0.0:
        total, c, k_now = 0.0, 0.0, 0.0
    else:
        k_now = k
    for i in range(3):
        force[i] = total * n[i]
        for j in range(3):
            across = (1.0 if i == j else 0.0) - n[i] * n[j]
            stiff[i, j] = k_now * n[i] * n[j] + total / distance * across
            loss[i, j] = c * n[i] * n[j]
    by_length = elastic * (n[0] - 1.0) - 0.5 * elastic * s / length
    return elastic, 0.5 * elastic * s, (total - elastic) * rate, -values[2] * by_length


@inner()
def ground_push(values, angle, speed, u, v):
    """Force on the lift times -1 (so it is negative), slopes by lift and rate, elastic force, potential, lost power."""
    stiffness, damping, level, rise = values[0], values[1], values[2], values[3]
    s = level - u - rise * angle
    if s <= 0.0:
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    rate = -v - rise * speed
    elastic = stiffness * s
    total = elastic + damping * rate
    if total <= 0.0:
        return 0.0, 0.0, 0.0, elastic, 0.5 * elastic * s, -elastic * rate
    return -total, stiffness, damping, elastic, 0.5 * elastic * s, damping * rate * rate
