"""Backward paths of light through air and off the ground, many at once, with the sun seen from every turn.

A path goes from the eye: a distance is sampled by the light that scatters along the ray (the ground, where the ray
meets it, by what it reflects), then a direction by the phase functions, and so on. All three wavelengths share a path;
each is weighted by its own integrand over the common probability. At each turn sunlight is added, by either convention
of air_single. The k-th turn is light of order k; a reflection counts as an order.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .air_medium import AirParameters, Floats, densities, mie_phase, rayleigh_phase
from .air_rays import Rays
from .air_single import sun_seen
from .air_tables import BINS, DistanceTable, LengthTable, sampling_edges
from .air_transmittance import transmittance_of

ROULETTE_FROM = 3
"""The first order after which paths may end by chance."""
ROULETTE_WEIGHT = 0.05
"""Paths whose weight is below this share of a whole one end with a probability that leaves it as their weight."""

GLOW_SHARE, GLOW_HEIGHT, GLOW_ASYMMETRY = 0.5, 0.15, 0.7
"""With the sun below the horizon: how many directions are sampled towards the light over it, and how wide."""

Uniforms = Callable[[int], Floats]


@dataclass
class Front:
    """The ends of the paths still alive."""

    lane: NDArray[np.intp]
    position_m: Floats
    direction: Floats
    weight: Floats
    """(N, 3) what light from here along the path counts at the eye."""


@dataclass(frozen=True)
class Tracer:
    """Tables of one air, for paths to one sun."""

    air: AirParameters
    lengths: LengthTable
    distances: DistanceTable
    sun: Floats
    """(3,) unit direction to the sun."""
    sun_visibility: str = "disc"

    def trace(self, first: Front, rays: Rays, numbers: Uniforms, most_orders: int, fixed: bool) -> Floats:
        """(lanes, most_orders, 3) radiance by order of each path.

        `first`: lanes 0..n-1 at the starts of `rays`. `numbers(k)`: (n, 5) uniform numbers of the k-th turn. `fixed`:
        all rays are the same one, and may end in mid-air; the distribution along it is then computed for it alone.
        Light of the ground where the first ray meets it is left out.
        """
        light = np.zeros((len(first.lane), most_orders, self.air.wavelengths))
        front = first
        for order in range(most_orders):
            drawn = numbers(order)
            u = drawn[front.lane]
            if order == 0:
                s, perigee, end, on_ground = rays.start_m, rays.level_m2, rays.end_m, np.zeros(len(u), dtype=bool)
            else:
                s, perigee, end, hits = self._segment(front)
                on_ground = self._choose_ground(front, s, perigee, end, hits, u)
            air_lanes, ground_lanes = np.nonzero(~on_ground)[0], np.nonzero(on_ground)[0]
            edges = self._edges(rays, fixed) if order == 0 else None
            parts = [
                self._turn_in_air(front, air_lanes, s, perigee, end, u, edges, light, order),
                self._turn_on_ground(front, ground_lanes, s, perigee, end, u, light, order),
            ]
            front = _join(parts)
            if order + 1 >= ROULETTE_FROM:
                front = _roulette(front, drawn[front.lane, 4])
            if len(front.lane) == 0:
                break
        return light

    def _edges(self, rays: Rays, fixed: bool) -> Floats:
        if fixed:
            one = sampling_edges(self.lengths, rays.level_m2[:1], rays.start_m[:1], rays.end_m[:1], 4 * BINS, even=0.2)
            return np.broadcast_to(one, (len(rays.level_m2), 4 * BINS + 1))
        level = rays.level_m2 + rays.start_m**2
        return self.distances.edges[self.distances.cells(level, rays.start_m, rays.hits_ground)]

    def _segment(self, front: Front) -> tuple[Floats, Floats, Floats, NDArray[np.bool_]]:
        """Start and end from the perigee, the perigee's level, and whether the ground ends the ray."""
        air = self.air
        radius = np.sqrt(np.einsum("ij,ij->i", front.position_m, front.position_m))
        level = np.maximum(air.level(radius - air.radius_m), 0.0)
        s = np.einsum("ij,ij->i", front.position_m, front.direction)
        perigee = level - s * s
        hits = (perigee < 0.0) & (s < 0.0)
        top = np.sqrt(np.maximum(air.level(air.thickness_m) - perigee, 0.0))
        end = np.where(hits, -np.sqrt(np.maximum(-perigee, 0.0)), top)
        return s, perigee, np.maximum(end, s), hits

    def _choose_ground(
        self, front: Front, s: Floats, perigee: Floats, end: Floats, hits: NDArray[np.bool_], u: Floats
    ) -> NDArray[np.bool_]:
        """Draws with u[:, 1] between the ground and the air before it, and divides the weights by the probabilities."""
        chosen = np.zeros(len(s), dtype=bool)
        at = np.nonzero(hits)[0]
        albedo = np.asarray(self.air.ground_albedo, dtype=float)
        if len(at) == 0 or not albedo.any():
            return chosen
        through = transmittance_of(self.air, self.lengths.between(perigee[at], s[at], end[at]))
        weight = front.weight[at]
        ground, scattered = (weight * through * albedo).sum(axis=1), (weight * (1.0 - through)).sum(axis=1)
        share = ground / np.maximum(ground + scattered, 1e-300)
        take = u[at, 1] < share
        chosen[at] = take
        front.weight[at] = np.where(
            take[:, None], weight * through * albedo / np.maximum(share, 1e-300)[:, None],
            weight / np.maximum(1.0 - share, 1e-300)[:, None],
        )  # fmt: skip
        u[at, 1] = np.where(
            take, u[at, 1] / np.maximum(share, 1e-300), (u[at, 1] - share) / np.maximum(1 - share, 1e-300)
        )
        return chosen

    def _turn_in_air(
        self, front: Front, at: NDArray[np.intp], s: Floats, perigee: Floats, end: Floats, u: Floats,
        edges: Floats | None, light: Floats, order: int,
    ) -> Front:  # fmt: skip
        """Scatters the paths `at`: sunlight of the turn goes to `light`, what goes on is returned."""
        air = self.air
        s, perigee, end, u = s[at], perigee[at], end[at], u[at]
        if edges is None:
            hits = (perigee < 0.0) & (s < 0.0)
            edges = self.distances.edges[self.distances.cells(perigee + s * s, s, hits)]
        else:
            edges = edges[at]
        way, per_way = _sample_edges(edges, u[:, 0])
        t = (end - s) * way
        here = s + t
        level = perigee + here * here
        weight = front.weight[at] * transmittance_of(air, self.lengths.between(perigee, s, here))
        weight *= ((end - s) / per_way)[:, None]
        density = densities(air, air.height(level))
        rayleigh = weight * density[:, :1] * air.scattering_per_m[0]
        mie = weight * density[:, 1:2] * air.scattering_per_m[1]
        position = front.position_m[at] + front.direction[at] * t[:, None]
        direction = front.direction[at]
        cosine = direction @ self.sun
        phased = rayleigh * rayleigh_phase(cosine)[:, None] + mie * mie_phase(cosine, air.mie_asymmetry)[:, None]
        light[front.lane[at], order] += phased * self.sunlight(level, position @ self.sun)
        total = (rayleigh + mie).sum(axis=1)
        share = rayleigh.sum(axis=1) / np.maximum(total, 1e-300)
        lobes = Lobes.at(position, self.sun, direction, share, air.mie_asymmetry)
        after = lobes.sample(u[:, 1], u[:, 2], u[:, 3])
        turn = np.clip(np.einsum("ij,ij->i", direction, after), -1.0, 1.0)
        onwards = rayleigh * rayleigh_phase(turn)[:, None] + mie * mie_phase(turn, air.mie_asymmetry)[:, None]
        onwards /= lobes.density(after, turn)[:, None]
        return Front(front.lane[at], position, after, onwards)

    def _turn_on_ground(
        self, front: Front, at: NDArray[np.intp], s: Floats, perigee: Floats, end: Floats, u: Floats,
        light: Floats, order: int,
    ) -> Front:  # fmt: skip
        """Reflects the paths `at`, whose weights hold the way down and the albedo already."""
        if len(at) == 0:
            return Front(at, np.empty((0, 3)), np.empty((0, 3)), np.empty((0, self.air.wavelengths)))
        air, u = self.air, u[at]
        position = front.position_m[at] + front.direction[at] * (end[at] - s[at])[:, None]
        up = position / np.linalg.norm(position, axis=1, keepdims=True)
        rise = up @ self.sun
        lit = ground_light(air, self.lengths, rise)
        light[front.lane[at], order] += front.weight[at] * lit / np.pi
        direction = turned(up, np.sqrt(u[:, 2]), 2.0 * np.pi * u[:, 3])
        return Front(front.lane[at], up * air.radius_m, direction, front.weight[at])

    def sunlight(self, level_m2: Floats, rise_m: Floats) -> Floats:
        """(N, 3) as `air_single.sun_light`, from the table."""
        air = self.air
        horizon = np.sqrt(np.maximum(level_m2, 0.0))
        seen = sun_seen(air, level_m2, rise_m, self.sun_visibility)
        light = np.zeros((len(seen), air.wavelengths))
        lit = seen > 0.0
        start = np.maximum(rise_m[lit], -horizon[lit])
        light[lit] = seen[lit, None] * transmittance_of(air, self.lengths.to_space(level_m2[lit], start))
        return light


def ground_light(air: AirParameters, lengths: LengthTable, cosine: Floats) -> Floats:
    """(N, 3) sunlight on level ground: transmittance times the mean cosine over the part of the disc that is up."""
    through = transmittance_of(air, lengths.to_space(np.zeros(len(cosine)), air.radius_m * np.maximum(cosine, 0.0)))
    return through * disc_cosine(cosine, air.sun_angular_radius_rad)[:, None]


def disc_cosine(cosine: Floats, radius_rad: float) -> Floats:
    """Mean of max(cosine, 0) over the sun's disc: (c + a)^2 / (4 a) while it rises, as Bruneton 2017 has it."""
    a = max(radius_rad, 1e-12)
    return np.where(cosine >= a, cosine, np.clip(cosine + a, 0.0, None) ** 2 / (4.0 * a))


def _sample_edges(edges: Floats, u: Floats) -> tuple[Floats, Floats]:
    """Positions (N,) in 0..1 and their probability densities, of rows of edges of equal probability."""
    bins = edges.shape[1] - 1
    k = np.minimum((u * bins).astype(np.intp), bins - 1)
    row = np.arange(len(u))
    a = edges[row, k]
    width = edges[row, k + 1] - a
    return a + width * (u * bins - k), 1.0 / (bins * width)


@dataclass(frozen=True)
class Lobes:
    """What directions are sampled from: both phase functions, and at dusk also the glow over the sun's horizon."""

    direction: Floats
    glow: Floats
    """(N, 3) the middle of the glow."""
    shares: Floats
    """(N, 3) probabilities of molecules, dust, glow."""
    asymmetry: float

    @staticmethod
    def at(position: Floats, sun: Floats, direction: Floats, rayleigh_share: Floats, asymmetry: float) -> Lobes:
        up = position / np.sqrt(np.einsum("ij,ij->i", position, position))[:, None]
        rise = up @ sun
        glow = sun + (np.maximum(-rise, 0.0) + GLOW_HEIGHT)[:, None] * up
        glow /= np.maximum(np.sqrt(np.einsum("ij,ij->i", glow, glow)), 1e-9)[:, None]
        share = GLOW_SHARE * np.clip(0.5 - 5.0 * rise, 0.0, 1.0)
        rest = 1.0 - share
        return Lobes(
            direction, glow, np.stack([rest * rayleigh_share, rest * (1 - rayleigh_share), share], 1), asymmetry
        )

    def sample(self, choice: Floats, u: Floats, v: Floats) -> Floats:
        """Unit directions (N, 3)."""
        z = 4.0 * u - 2.0
        root = np.sqrt(z * z + 1.0)
        cosine = np.cbrt(z + root) + np.cbrt(z - root)
        molecules, glows = choice < self.shares[:, 0], choice >= self.shares[:, 0] + self.shares[:, 1]
        cosine = np.where(molecules, cosine, _henyey_cosine(self.asymmetry, u))
        cosine = np.clip(np.where(glows, _henyey_cosine(GLOW_ASYMMETRY, u), cosine), -1.0, 1.0)
        return turned(np.where(glows[:, None], self.glow, self.direction), cosine, 2.0 * np.pi * v)

    def density(self, after: Floats, turn: Floats) -> Floats:
        """Probability per steradian (N,) of directions whose cosine to the old one is `turn`."""
        glow = _henyey(GLOW_ASYMMETRY, np.einsum("ij,ij->i", after, self.glow))
        phases = np.stack([rayleigh_phase(turn), _henyey(self.asymmetry, turn), glow], axis=1)
        return np.einsum("ij,ij->i", self.shares, phases)


def _henyey(g: float, cosine: Floats) -> Floats:
    """Henyey and Greenstein's phase function, which is near Cornette's and Shanks's and easily sampled."""
    return (1.0 - g * g) / (4.0 * np.pi * (1.0 + g * g - 2.0 * g * cosine) ** 1.5)


def _henyey_cosine(g: float, u: Floats) -> Floats:
    if abs(g) < 1e-6:
        return 2.0 * u - 1.0
    return (1.0 + g * g - ((1.0 - g * g) / (1.0 - g + 2.0 * g * u)) ** 2) / (2.0 * g)


def turned(axis: Floats, cosine: Floats, azimuth: Floats) -> Floats:
    """Unit directions (N, 3) at angles from unit axes (frame of Duff et al. 2017)."""
    x, y, z = axis.T
    sign = np.copysign(1.0, z)
    a = -1.0 / (sign + z)
    b = x * y * a
    sine = np.sqrt(np.maximum(1.0 - cosine * cosine, 0.0))
    c, s = sine * np.cos(azimuth), sine * np.sin(azimuth)
    turned = np.stack(
        [
            c * (1.0 + sign * x * x * a) + s * b + cosine * x,
            c * sign * b + s * (sign + y * y * a) + cosine * y,
            -c * sign * x - s * y + cosine * z,
        ],
        axis=1,
    )
    return turned / np.sqrt(np.einsum("ij,ij->i", turned, turned))[:, None]


def _join(parts: list[Front]) -> Front:
    return Front(
        np.concatenate([p.lane for p in parts]),
        np.concatenate([p.position_m for p in parts]),
        np.concatenate([p.direction for p in parts]),
        np.concatenate([p.weight for p in parts]),
    )


def _roulette(front: Front, u: Floats) -> Front:
    """Ends faint paths by chance, so that on average nothing is lost; paths without weight end."""
    brightest = front.weight.max(axis=1)
    chance = np.minimum(brightest / ROULETTE_WEIGHT, 1.0)
    stays = u < chance
    weight = front.weight[stays] / chance[stays, None]
    return Front(front.lane[stays], front.position_m[stays], front.direction[stays], weight)
