"""The tables of Bruneton 2017 in float64, term by term as printed: by radii, with two look-ups for every direction.

Written from the published formulas, apart from the shaders, which work with altitudes and group their sums. Small
tables only: every sum over directions is an array.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from planetfall.systems.atmosphere import AirBlock, PaperSizes

Floats = NDArray[np.float64]


def _lookup(table: Floats, *units: Floats) -> Floats:
    """Linear interpolation; units 0..1 are the first .. the last texel of each axis, the channels come last."""
    whole, part = [], []
    for unit, size in zip(units, table.shape, strict=False):
        x = np.clip(unit, 0.0, 1.0) * (size - 1)
        low = np.minimum(x.astype(int), size - 2)
        whole.append(low)
        part.append((x - low)[..., None])
    found = np.zeros(())
    for corner in np.ndindex(*(2,) * len(units)):
        weight = np.ones(())
        for share, at in zip(part, corner, strict=True):
            weight = weight * (share if at else 1.0 - share)
        found = found + weight * table[tuple(low + at for low, at in zip(whole, corner, strict=True))]
    return found


def _trapezoid(steps: int) -> Floats:
    weights = np.ones(steps + 1)
    weights[0] = weights[-1] = 0.5
    return weights


@dataclass
class PaperTwin:
    """All tables of one air. Scattering tables are (r, mu, mu_s, nu, 3), transmittance and irradiance (r, mu, 3)."""

    air: AirBlock
    sizes: PaperSizes
    orders: list[Floats] = field(default_factory=list)
    """of the second order and higher, each alone, phase functions included"""

    def __post_init__(self) -> None:
        a = self.air
        self.bottom, self.top = a.radius_m, a.top_radius_m
        self.longest = np.sqrt(self.top**2 - self.bottom**2)
        self.mu_s_min = np.cos(np.radians(self.sizes.max_sun_zenith_deg))
        self._transmittance()
        self._texels()
        self._single()
        self._irradiance_axes()
        r, mu_s = self.irradiance_at
        alpha = a.sun_radius_rad
        rising = (mu_s + alpha) ** 2 / (4.0 * alpha)
        cosine = np.where(mu_s < -alpha, 0.0, np.where(mu_s > alpha, mu_s, rising))
        floor = self.to_top(r, mu_s) * cosine[..., None]
        self.irradiance = np.zeros_like(floor)
        self.scattering = self.rayleigh.copy()
        for n in range(2, self.sizes.orders + 1):
            density = self._density(n, floor)
            floor = self._indirect(n - 1)
            self.irradiance += floor
            self.orders.append(self._multiple(density))
            self.scattering += self.orders[-1] / self.phases(self.at[3])[0][..., None]

    # -- geometry and air ---------------------------------------------------------------------------------------------

    def distance_to_top(self, r: Floats, mu: Floats) -> Floats:
        return np.maximum(-r * mu + np.sqrt(np.maximum(r * r * (mu * mu - 1.0) + self.top**2, 0.0)), 0.0)

    def distance_to_floor(self, r: Floats, mu: Floats) -> Floats:
        return np.maximum(-r * mu - np.sqrt(np.maximum(r * r * (mu * mu - 1.0) + self.bottom**2, 0.0)), 0.0)

    def hits(self, r: Floats, mu: Floats) -> NDArray[np.bool_]:
        return (mu < 0.0) & (r * r * (mu * mu - 1.0) + self.bottom**2 >= 0.0)

    def densities(self, r: Floats) -> tuple[Floats, Floats, Floats]:
        h, a = r - self.bottom, self.air
        tent = np.maximum(1.0 - np.abs(h - a.absorber_height_m) * a.absorber_slope_per_m, 0.0)
        return np.exp(-h / a.rayleigh_height_m)[..., None], np.exp(-h / a.mie_height_m)[..., None], tent[..., None]

    def phases(self, nu: Floats) -> tuple[Floats, Floats]:
        g = self.air.mie_asymmetry
        k = 3.0 / (8.0 * np.pi) * (1.0 - g * g) / (2.0 + g * g)
        return 3.0 / (16.0 * np.pi) * (1.0 + nu * nu), k * (1.0 + nu * nu) / (1.0 + g * g - 2.0 * g * nu) ** 1.5

    def along(self, r: Floats, cosine: Floats, step: Floats, distance: Floats, mu: Floats) -> tuple[Floats, Floats]:
        there = np.clip(np.sqrt(distance**2 + 2.0 * r * mu * distance + r * r), self.bottom, self.top)
        return there, np.clip((r * cosine + step) / there, -1.0, 1.0)

    # -- transmittance ------------------------------------------------------------------------------------------------

    def _transmittance(self) -> None:
        width, height = self.sizes.transmittance
        rho = np.linspace(0.0, 1.0, height)[:, None] * self.longest
        r = np.sqrt(rho**2 + self.bottom**2)
        shortest, farthest = self.top - r, rho + self.longest
        d = shortest + np.linspace(0.0, 1.0, width) * (farthest - shortest)
        with np.errstate(divide="ignore", invalid="ignore"):
            mu = np.where(d > 0.0, (self.longest**2 - rho**2 - d * d) / (2.0 * r * d), 1.0)
        mu = np.clip(mu, -1.0, 1.0)
        steps = np.arange(501) / 500.0 * self.distance_to_top(r, mu)[..., None]
        there, _ = self.along(r[..., None], mu[..., None], steps, steps, mu[..., None])
        weights = _trapezoid(500)[:, None]
        sums = [(weights * part).sum(2) * steps[..., 1:2] for part in self.densities(there)]
        rgb = [np.array(c) for c in (self.air.rayleigh_per_m, self.air.mie_extinction_per_m, self.air.absorption_per_m)]
        self.transmittance = np.exp(-sum(s * c for s, c in zip(sums, rgb, strict=True)))

    def to_top(self, r: Floats, mu: Floats) -> Floats:
        rho = np.sqrt(np.maximum(r * r - self.bottom**2, 0.0))
        shortest, farthest = self.top - r, rho + self.longest
        x = (self.distance_to_top(r, mu) - shortest) / (farthest - shortest)
        return _lookup(self.transmittance, *np.broadcast_arrays(rho / self.longest, x))

    def between(self, r: Floats, mu: Floats, d: Floats, hits: NDArray[np.bool_]) -> Floats:
        there, mu_there = self.along(r, mu, d, d, mu)
        down = self.to_top(there, -mu_there) / self.to_top(r, -mu)
        up = self.to_top(r, mu) / self.to_top(there, mu_there)
        return np.minimum(np.where(hits[..., None], down, up), 1.0)

    def sun(self, r: Floats, mu_s: Floats) -> Floats:
        sine = self.bottom / r
        soft = self.air.sun_radius_rad * sine
        t = np.clip((mu_s + np.sqrt(np.maximum(1.0 - sine**2, 0.0)) + soft) / (2.0 * soft), 0.0, 1.0)
        return self.to_top(r, mu_s) * (t * t * (3.0 - 2.0 * t))[..., None]

    # -- scattering ---------------------------------------------------------------------------------------------------

    def _sun_constants(self) -> tuple[float, float]:
        d = self.distance_to_top(np.array(self.bottom), np.array(self.mu_s_min))
        shortest = self.top - self.bottom
        return shortest, float((d - shortest) / (self.longest - shortest))

    def _texels(self) -> None:
        """(r, mu, mu_s, nu) of every texel, and whether its rays end on the floor."""
        sizes = self.sizes.scattering
        i, j, k, n = np.meshgrid(*(np.arange(s) for s in sizes), indexing="ij")
        rho = self.longest * i / (sizes[0] - 1)
        r = np.sqrt(rho**2 + self.bottom**2)
        half = sizes[1] // 2
        hits = j < half
        x = np.where(hits, half - 1 - j, j - half) / (half - 1)
        shortest = np.where(hits, r - self.bottom, self.top - r)
        farthest = np.where(hits, rho, rho + self.longest)
        d = shortest + (farthest - shortest) * x
        with np.errstate(divide="ignore", invalid="ignore"):
            down = np.where(d > 0.0, -(rho**2 + d * d) / (2.0 * r * d), -1.0)
            up = np.where(d > 0.0, (self.longest**2 - rho**2 - d * d) / (2.0 * r * d), 1.0)
        mu = np.clip(np.where(hits, down, up), -1.0, 1.0)
        least, last = self._sun_constants()
        x = k / (sizes[2] - 1)
        a = last * (1.0 - x) / (1.0 + x * last)
        d = least + a * (self.longest - least)
        mu_s = np.clip((self.longest**2 - d * d) / (2.0 * self.bottom * d), -1.0, 1.0)
        spread = np.sqrt((1.0 - mu * mu) * (1.0 - mu_s * mu_s))
        nu = np.clip(2.0 * n / (sizes[3] - 1) - 1.0, mu * mu_s - spread, mu * mu_s + spread)
        self.at, self.at_hits = (r, mu, mu_s, nu), hits

    def read(self, table: Floats, r: Floats, mu: Floats, mu_s: Floats, nu: Floats, hits: NDArray[np.bool_]) -> Floats:
        """A scattering table (r, mu, mu_s, nu, 3) at places of any one shape (...,) -> (..., 3)."""
        r, mu, mu_s, nu, hits = np.broadcast_arrays(r, mu, mu_s, nu, hits)
        rho = np.sqrt(np.maximum(r * r - self.bottom**2, 0.0))
        half = self.sizes.scattering[1] // 2
        h, above = r - self.bottom, self.top - r
        with np.errstate(divide="ignore", invalid="ignore"):
            down = np.where(rho > h, (self.distance_to_floor(r, mu) - h) / (rho - h), 0.0)
        up = (self.distance_to_top(r, mu) - above) / (rho + self.longest - above)
        least, last = self._sun_constants()
        a = (self.distance_to_top(np.array(self.bottom), mu_s) - least) / (self.longest - least)
        x_s = np.maximum(1.0 - a / last, 0.0) / (1.0 + a)
        floor_half = _lookup(table[:, :half][:, ::-1], rho / self.longest, down, x_s, 0.5 * nu + 0.5)
        top_half = _lookup(table[:, half:], rho / self.longest, up, x_s, 0.5 * nu + 0.5)
        return np.where(hits[..., None], floor_half, top_half)

    def _ray(self) -> tuple[Floats, ...]:
        """Along the ray of every texel, 50 steps: weights times step, radius, mu, mu_s, transmittance."""
        r, mu, mu_s, nu = (c[..., None] for c in self.at)
        hits = self.at_hits[..., None]
        end = np.where(hits, self.distance_to_floor(r, mu), self.distance_to_top(r, mu))
        d = np.arange(51) / 50.0 * end
        there, mu_there = self.along(r, mu, d, d, mu)
        _, sun_there = self.along(r, mu_s, d * nu, d, mu)
        through = self.between(*np.broadcast_arrays(r, mu), d, np.broadcast_to(hits, d.shape))
        return (_trapezoid(50) * end / 50.0)[..., None], there, mu_there, sun_there, through

    def _single(self) -> None:
        weight, there, _, sun_there, through = self._ray()
        light = weight * through * self.sun(there, sun_there)
        density = self.densities(there)
        self.rayleigh = (light * density[0]).sum(-2) * np.array(self.air.rayleigh_per_m)
        self.mie = (light * density[1]).sum(-2) * np.array(self.air.mie_scattering_per_m)

    def before(self, n: int, *place: Floats) -> Floats:
        """Radiance of order n alone; place: r, mu, mu_s, nu, hits."""
        if n > 1:
            return self.read(self.orders[n - 2], *place)
        by_rayleigh, by_mie = (p[..., None] for p in self.phases(place[3]))
        return self.read(self.rayleigh, *place) * by_rayleigh + self.read(self.mie, *place) * by_mie

    def _density(self, n: int, floor: Floats) -> Floats:
        r, mu, mu_s, nu = (c[..., None, None] for c in self.at)
        theta = (np.arange(16) + 0.5)[:, None] * np.pi / 16
        phi = (np.arange(32) + 0.5) * np.pi / 16
        sine = np.sqrt(1.0 - mu * mu)
        with np.errstate(divide="ignore", invalid="ignore"):
            sun_x = np.where(sine > 0.0, (nu - mu * mu_s) / sine, 0.0)
        sun_y = np.sqrt(np.maximum(1.0 - sun_x**2 - mu_s * mu_s, 0.0))
        x, y, z = np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)
        nu_before = np.clip(x * sun_x + y * sun_y + z * mu_s, -1.0, 1.0)
        nu_here = np.clip(x * sine + z * mu, -1.0, 1.0)
        cone_hits = self.hits(r, z)
        place = np.broadcast_arrays(r, z, mu_s, nu_before, cone_hits)
        light = self.before(n - 1, *place)
        d = self.distance_to_floor(r, z)
        d = np.where(cone_hits, d, 0.0)
        cosine = np.clip((r * mu_s + d * nu_before) / self.bottom, -1.0, 1.0)
        lit = _lookup(floor, np.zeros_like(cosine), 0.5 * cosine + 0.5) * np.array(self.air.ground_albedo) / np.pi
        through = self.between(*np.broadcast_arrays(r, z), d, cone_hits)
        light = light + np.where(cone_hits[..., None], through * lit, 0.0)
        by_rayleigh, by_mie = (p[..., None] for p in self.phases(nu_here))
        gas, haze, _ = self.densities(r)
        scattered = by_rayleigh * gas * np.array(self.air.rayleigh_per_m)
        scattered = scattered + by_mie * haze * np.array(self.air.mie_scattering_per_m)
        return (light * scattered * (np.sin(theta) * (np.pi / 16) ** 2)[..., None]).sum((-3, -2))

    def _multiple(self, density: Floats) -> Floats:
        weight, there, mu_there, sun_there, through = self._ray()
        source = self.read(density, there, mu_there, sun_there, self.at[3][..., None], self.at_hits[..., None])
        return (weight * through * source).sum(-2)

    def _irradiance_axes(self) -> None:
        width, height = self.sizes.irradiance
        r = self.bottom + np.linspace(0.0, 1.0, height) * (self.top - self.bottom)
        self.irradiance_at = np.meshgrid(r, np.linspace(-1.0, 1.0, width), indexing="ij")

    def _indirect(self, n: int) -> Floats:
        r, mu_s = (c[..., None, None] for c in self.irradiance_at)
        theta = (np.arange(16) + 0.5)[:, None] * np.pi / 32
        phi = (np.arange(64) + 0.5) * np.pi / 32
        nu = np.clip(np.cos(phi) * np.sin(theta) * np.sqrt(1.0 - mu_s**2) + np.cos(theta) * mu_s, -1.0, 1.0)
        light = self.before(n, *np.broadcast_arrays(r, np.cos(theta), mu_s, nu, False))
        return (light * (np.cos(theta) * np.sin(theta) * (np.pi / 32) ** 2)[..., None]).sum((-3, -2))
