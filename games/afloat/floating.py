"""Rigid bodies that float: each is cut into upright columns, and each column is lifted by the water it displaces.

All bodies' columns ask OceanSampler for the sea in one call a step. Positions are planet-centred metres in planet axes
throughout, in float64: no local frame is needed.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

import planetfall as pf

from .turning import axes_of, turned

Floats = NDArray[np.float64]

WATER_KG_M3 = 1025.0
STEP_S = 1.0 / 60.0


@dataclass(frozen=True)
class Hull:
    """What floats, in its own axes: +X ahead, +Z up, z = 0 its waterline at rest.

    columns: (K, 4): x, y, area m^2, bottom z of upright columns; top_m: z of their upper ends. drag: share of critical
    damping of (surge, sway, heave) and of (roll, pitch, yaw). height_m: of the centre of mass, z; gyration_m: radii of
    gyration about its axes.
    """

    columns: Floats
    top_m: float
    drag: tuple[float, float, float] = (0.1, 0.4, 0.5)
    turn_drag: tuple[float, float, float] = (0.5, 0.5, 0.5)
    height_m: float = 0.0
    gyration_m: tuple[float, float, float] = (0.5, 0.5, 0.5)

    @property
    def mass_kg(self) -> float:
        """That of the water displaced up to z = 0, so it floats at its waterline."""
        return WATER_KG_M3 * float(np.sum(self.columns[:, 2] * np.maximum(-self.columns[:, 3], 0.0)))

    @property
    def area_m2(self) -> float:
        return float(np.sum(self.columns[:, 2]))


def disc_hull(diameter_m: float, draft_m: float, freeboard_m: float, rings: int = 2) -> Hull:
    """An upright cylinder with a weight in its bottom: columns of equal area on rings."""
    columns = []
    for ring in range(rings):
        inner, outer = (0.5 * diameter_m * k / rings for k in (ring, ring + 1))
        count = 1 if ring == 0 else 8 * ring
        radius = 0.0 if ring == 0 else (2.0 / 3.0) * (outer**3 - inner**3) / (outer**2 - inner**2)
        area = np.pi * (outer**2 - inner**2) / count
        for angle in 2.0 * np.pi * np.arange(count) / count:
            columns.append((radius * np.cos(angle), radius * np.sin(angle), area, -draft_m))
    return Hull(np.array(columns), freeboard_m, (0.3, 0.3, 0.5), (0.4, 0.4, 0.6), -0.5 * draft_m, (0.5, 0.5, 0.5))


def boat_hull(sections: Floats, top_m: float) -> Hull:
    """Columns of a hull given by points (S, K, 3) of sections from stern to bow, each from port to starboard."""
    columns = []
    for aft, fore in pairwise(sections):
        for k in range(sections.shape[1] - 1):
            corners = np.stack([aft[k], aft[k + 1], fore[k + 1], fore[k]])
            x, y, z = corners.mean(axis=0)
            # Area as seen from above, by the cross product of the diagonals.
            d, e = corners[2, :2] - corners[0, :2], corners[3, :2] - corners[1, :2]
            area = 0.5 * abs(float(d[0] * e[1] - d[1] * e[0]))
            if area > 1e-6 and z < top_m:
                columns.append((x, y, area, z))
    table = np.array(columns)
    length, beam = np.ptp(sections[..., 0]), np.ptp(sections[..., 1])
    gyration = (0.35 * beam, 0.25 * length, 0.25 * length)
    # The centre of mass above the centre of buoyancy, or it would trim by the bow or the stern: x is moved below.
    under = np.maximum(-table[:, 3], 0.0) * table[:, 2]
    table[:, 0] -= np.sum(under * table[:, 0]) / np.sum(under)
    return Hull(table, top_m, (0.06, 0.5, 0.5), (0.35, 0.5, 0.8), 0.1, gyration)


@dataclass
class Body:
    """A hull at a place. position_m: of its origin (3,). quaternion: (x, y, z, w) from its axes to the planet's."""

    hull: Hull
    position_m: Floats
    quaternion: Floats
    velocity_m_s: Floats = field(default_factory=lambda: np.zeros(3))
    spin_rad_s: Floats = field(default_factory=lambda: np.zeros(3))
    """In its own axes."""
    anchored_at: Floats | None = None
    """A direction: a chain holds it there once it is further than chain_m."""
    chain_m: float = 3.0
    thrust_n: float = 0.0
    rudder: float = 0.0
    """Turning by the rudder, rad/s^2 about its z; to starboard below 0."""


class Flotilla:
    """Bodies on the sea of a scene. time_s goes on with `step`."""

    def __init__(self, sampler: pf.OceanSampler, bodies: list[Body], gravity_m_s2: float, time_s: float = 0.0) -> None:
        self.sampler, self.bodies, self.gravity_m_s2, self.time_s = sampler, bodies, gravity_m_s2, time_s
        self._owners = np.concatenate([np.full(len(b.hull.columns), i) for i, b in enumerate(bodies)])

    def step(self) -> None:
        """STEP_S further: velocities first, then places (symplectic Euler)."""
        axes = [axes_of(b.quaternion) for b in self.bodies]
        bottoms = np.concatenate([
            b.position_m + b.hull.columns[:, [0, 1, 3]] @ a.T for b, a in zip(self.bodies, axes, strict=True)
        ])  # fmt: skip
        away = np.linalg.norm(bottoms, axis=1)
        sea = self.sampler.height(bottoms, self.time_s) + self.sampler.radius_m
        flow = self._flow()
        for i, (body, frame) in enumerate(zip(self.bodies, axes, strict=True)):
            mine = self._owners == i
            self._move(body, frame, bottoms[mine], (sea - away)[mine], flow[i])
        self.time_s += STEP_S

    def _flow(self) -> Floats:
        """Velocity of the water at the surface (N, 3) at each body: how waves move the points of the calm sea there."""
        places = np.array([b.position_m for b in self.bodies])
        step = 0.05
        times = self.time_s + np.repeat([-step, step], len(places))
        back, ahead = np.split(self.sampler.displacement(np.tile(places, (2, 1)), times), 2)
        return (ahead - back) / (2.0 * step)

    def _move(self, body: Body, frame: Floats, bottoms: Floats, depths: Floats, flow: Floats) -> None:
        hull, g = body.hull, self.gravity_m_s2
        up = body.position_m / np.linalg.norm(body.position_m)
        mass = hull.mass_kg
        tall = hull.top_m - hull.columns[:, 3]
        # A column that leans still ends in the water's level: along the column it is longer.
        wet = np.clip(depths / max(float(frame[:, 2] @ up), 0.3), 0.0, tall)
        lift = WATER_KG_M3 * g * hull.columns[:, 2] * wet
        # Pressure pushes along the water's normal: the slope of the sea over the hull, by least squares.
        arms = bottoms - body.position_m
        level = arms - np.outer(arms @ up, up)
        middle = level - level.mean(axis=0)
        rise = (depths + arms @ up) - (depths + arms @ up).mean()
        slope = np.linalg.lstsq(middle, rise, rcond=1e-6)[0]
        push = up - slope
        wet_share = float(np.sum(wet * hull.columns[:, 2]) / np.sum(tall * hull.columns[:, 2]))

        stiff = WATER_KG_M3 * g * hull.area_m2
        rate = 2.0 * np.sqrt(stiff * mass) * np.array(hull.drag) * min(2.0 * wet_share, 1.0)
        slip = frame.T @ (body.velocity_m_s - flow)
        force = lift.sum() * push - mass * g * up - frame @ (rate * slip) + frame[:, 0] * body.thrust_n
        if body.anchored_at is not None:
            away = body.position_m - body.anchored_at * np.linalg.norm(body.position_m)
            taut = np.linalg.norm(away)
            if taut > body.chain_m:
                force -= away / taut * (taut - body.chain_m) * 0.15 * stiff
        centre = frame[:, 2] * hull.height_m
        # Each column lifts at the middle of what is wet of it.
        at = arms + 0.5 * wet[:, None] * frame[:, 2] - centre
        torque = frame.T @ np.cross(at, lift[:, None] * push).sum(axis=0)
        inertia = mass * np.array(hull.gyration_m) ** 2
        swing = 2.0 * np.sqrt(inertia * stiff * np.array(hull.gyration_m) ** 2) * np.array(hull.turn_drag)
        torque = torque - swing * min(2.0 * wet_share, 1.0) * body.spin_rad_s
        torque[2] += body.rudder * inertia[2]
        torque = torque - np.cross(body.spin_rad_s, inertia * body.spin_rad_s)

        body.spin_rad_s = body.spin_rad_s + torque / inertia * STEP_S
        body.velocity_m_s = body.velocity_m_s + force / mass * STEP_S
        # About the centre of mass.
        before = body.position_m + centre
        body.quaternion = turned(body.quaternion, body.spin_rad_s * STEP_S)
        body.position_m = before + body.velocity_m_s * STEP_S - axes_of(body.quaternion)[:, 2] * hull.height_m

    def waterline_m(self, body: Body) -> float:
        """How far the sea is above the body's waterline at the moment, in metres: the mean over its hull, z = 0."""
        hull = body.hull
        level = hull.columns[:, :3] * [1.0, 1.0, 0.0]
        places = body.position_m + level @ axes_of(body.quaternion).T
        above = self.sampler.height(places, self.time_s) + self.sampler.radius_m - np.linalg.norm(places, axis=1)
        return float(np.average(above, weights=hull.columns[:, 2]))
