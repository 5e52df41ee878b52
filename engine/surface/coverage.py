"""How much of the sphere a camera can see: z_s of the projected grid (Michelic 2018), the covered arc, and the proxy's.

A camera at distance d from the centre sees ground up to the central angle acos(r / d) + acos(r / R_max): its own
horizon, and beyond that the peaks that still rise above it. z_s = cot of that angle, formed as
(1 - (h/r)(s/r)) / (h/r + s/r) with h = sqrt(a (2 r + a)) and s likewise from the peak, which keeps its digits at every
altitude. Where ground lies below the reference sphere, r is the lowest sphere that is drawn, and altitude and peak are
measured from it.
"""

from dataclasses import dataclass

import numpy as np

SMALLEST_ALTITUDE = 1e-20
"""Altitudes are clamped to this fraction of the radius: it adds 1.4e-10 radii of arc and keeps z_s finite."""


@dataclass(frozen=True)
class Coverage:
    """The part of the sphere that has to be drawn."""

    half_angle_rad: float
    """Central angle from the camera's (or proxy's) foot to the farthest ground in sight, at most pi."""
    radius_m: float
    """The sphere that hides: the lowest drawn one."""
    z_s: float
    """cot(half_angle_rad); very negative when the whole sphere is in sight."""

    @property
    def arc_m(self) -> float:
        """Length of the covered arc from the foot to the limit, along the sphere that hides."""
        return self.half_angle_rad * self.radius_m

    @property
    def grid_offset(self) -> float:
        """z_s for the warped grid: sqrt(2) z_s below 0, where the grid's corners cover less than its edge midpoints."""
        return self.z_s if self.z_s >= 0.0 else float(np.sqrt(2.0)) * self.z_s


def horizon_tangent(altitude_m: float, radius_m: float) -> float:
    """Tangent length to the sphere as a multiple of its radius: sqrt(a (2 r + a)) / r; 0 for a <= 0."""
    altitude = max(float(altitude_m), 0.0)
    return float(np.sqrt(altitude / radius_m) * np.sqrt(2.0 + altitude / radius_m))


def coverage(
    altitude_m: float, radius_m: float, highest_m: float, lowest_m: float = 0.0, sideways_rad: float = 0.0
) -> Coverage:
    """What a camera sees, and with `sideways_rad` what any camera sees within that central angle of the foot.

    Altitude, highest and lowest ground are above the reference sphere of `radius_m`; `lowest_m` counts only below 0 (an
    ocean or plain above the reference sphere hides more than we claim, never less). Raises ValueError for NaN.
    """
    values = (altitude_m, radius_m, highest_m, lowest_m, sideways_rad)
    if not all(np.isfinite(v) for v in values) or radius_m + min(lowest_m, 0.0) <= 0.0:
        raise ValueError(
            "coverage: expected finite altitude, radius, heights and angle with lowest ground above the centre, found "
            f"altitude_m={altitude_m!r}, radius_m={radius_m!r}, highest_m={highest_m!r}, lowest_m={lowest_m!r}, "
            f"sideways_rad={sideways_rad!r}"
        )
    drop = min(float(lowest_m), 0.0)
    inner = float(radius_m) + drop
    h = horizon_tangent(max(float(altitude_m) - drop, SMALLEST_ALTITUDE * inner), inner)
    s = horizon_tangent(float(highest_m) - drop, inner)
    angle = float(np.arctan(h) + np.arctan(s)) + max(float(sideways_rad), 0.0)
    if angle >= np.pi:
        return Coverage(float(np.pi), inner, -1e16)
    if sideways_rad > 0.0:
        return Coverage(angle, inner, _cot_sum(h, s, float(sideways_rad)))
    # 1 - h s cancels only near a quarter turn, where its absolute error is that of the angle.
    return Coverage(angle, inner, (1.0 - h * s) / (h + s))


def _cot_sum(h: float, s: float, sideways_rad: float) -> float:
    """cot(atan h + atan s + sideways), from the product of the three complex numbers."""
    product = complex(1.0, h) * complex(1.0, s) * complex(np.cos(sideways_rad), np.sin(sideways_rad))
    return product.real / product.imag if product.imag > 1e-16 * abs(product) else -1e16


def proxy_coverage(
    highest_altitude_m: float, sideways_rad: float, radius_m: float, highest_m: float, lowest_m: float = 0.0
) -> Coverage:
    """What any camera of a proxy's cell sees: its highest altitude, plus its largest sideways angle."""
    return coverage(highest_altitude_m, radius_m, highest_m, lowest_m, sideways_rad)
