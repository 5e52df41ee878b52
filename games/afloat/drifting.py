"""Rafts that drift down rivers and across lakes to the sea, as the water of TerrainSampler carries them.

A raft keeps to the water's level and takes on the water's speed within seconds: what a body so light does in a river
follows from where it is, so steps may be as long as the water is wide, and a journey of weeks takes minutes. Its sweep,
a long oar, keeps it off shallow water along the banks, where it would crawl. Positions are planet-centred metres in
planet axes, in float64.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

import planetfall as pf

Floats = NDArray[np.float64]

LENGTH_M, BEAM_M, DRAFT_M = 5.0, 3.0, 0.2
"""Draft: how deep the logs lie in the water."""
_SPEED_S, _LEVEL_S, _TURN_S = 2.0, 0.4, 6.0
"""In which a raft takes on the water's speed, level and way, but for 1/e of what is missing."""
_PUSH_M_S = 1.0
"""How fast a raft slides off a bank at most."""
_SWEEP_M_S = 0.3
"""What a sweep moves a raft by, towards deeper water."""
_FLAT = 0.02
"""Ground less steep than this lifts a raft and pushes it nowhere."""
_STEEP = 0.3
"""Water steeper than this lets a raft slide down it across the current: the edge of a fall."""
_STRIDE_BY_DEPTH = 5.0
"""Rivers are 17 to 33 times as wide to a side as they are deep (docs/rivers.md): a quarter of that at most."""
_LEAST_M, _MOST_M = 0.5, 80.0
_SLOWEST_M_S = 0.002
"""Below this water stands still: where the sea has been reached."""
_SPOTS = np.array([[0.0, 0.0], [0.5, 0.5], [0.5, -0.5], [-0.5, -0.5], [-0.5, 0.5]]) * [LENGTH_M, BEAM_M]
"""The middle and the corners, ahead and to port."""


class Rafts:
    """N rafts in unit directions (N, 3), on water; each may be ahead of the others in time.

    ValueError for a place that is dry, with its index.
    """

    def __init__(self, sampler: pf.TerrainSampler, directions: ArrayLike, sea_level_m: float = 0.0) -> None:
        self.sampler, self.sea_level_m = sampler, sea_level_m
        up = np.atleast_2d(np.asarray(directions, dtype=np.float64))
        self.up = up / np.linalg.norm(up, axis=1)[:, None]
        water = sampler.water(self.up)
        dry = np.flatnonzero(water.depth_m <= 0.0)
        if dry.size:
            raise ValueError(f"directions[{dry[0]}]: a raft needs water, found dry ground; see TerrainSampler.water")
        count = len(self.up)
        self.height_m: Floats = water.level_m.copy()
        """(N,) of the waterlines above the reference sphere"""
        self.level_m: Floats = water.level_m.copy()
        """(N,) of the water below them; the last there was while a raft lies dry"""
        self.depth_m: Floats = water.depth_m.copy()
        """(N,) of the water at their middles"""
        self.aground_m = np.zeros(count)
        """(N,) how far the ground lifts them"""
        self.current_m_s = water.current_m_s.copy()
        self.velocity_m_s = water.current_m_s.copy()
        self.time_s = np.zeros(count)
        self._before_m_s, self._before_s = self.current_m_s, np.full(count, np.inf)
        self.ahead = _across(self.up, np.where(self._still()[:, None], [0.0, 0.0, 1.0], self.current_m_s))
        self._look()

    def _still(self) -> NDArray[np.bool_]:
        return np.linalg.norm(self.current_m_s, axis=1) < _SLOWEST_M_S

    @property
    def positions_m(self) -> Floats:
        """(N, 3) of the middles of their waterlines."""
        return self.up * (self.sampler.radius_m + self.height_m)[:, None]

    @property
    def at_sea(self) -> NDArray[np.bool_]:
        """(N,) where no current reaches, at the sea's level."""
        return (self.level_m == self.sea_level_m) & ~self.current_m_s.any(axis=1) & (self.depth_m > DRAFT_M)

    def longest_step_s(self) -> Floats:
        """(N,) until each raft has gone a small part of the water's width."""
        reach = np.clip(_STRIDE_BY_DEPTH * self.depth_m, _LEAST_M, _MOST_M)
        speed = np.maximum(*(np.linalg.norm(v, axis=1) for v in (self.velocity_m_s, self.current_m_s)))
        return reach / np.maximum(speed, _SLOWEST_M_S)

    def step(self, dt_s: ArrayLike) -> None:
        """Each raft (N,) seconds further; no more than `longest_step_s`."""
        dt = np.broadcast_to(np.asarray(dt_s, dtype=np.float64), self.time_s.shape)
        spots, depth, levels = self._seen
        aim = self._middle_of_step(dt) + self._sweep(depth)
        self.velocity_m_s = aim + (self.velocity_m_s - aim) * np.exp(-dt / _SPEED_S)[:, None]
        push = self._push(spots, depth, dt) + self._slide(levels, dt)
        into = np.minimum((self.velocity_m_s * push).sum(axis=1), 0.0)
        square = np.maximum((push * push).sum(axis=1), 1e-12)
        self.velocity_m_s -= push * (into / square)[:, None]
        moved = self.up + (self.velocity_m_s * dt[:, None] + push) / self.sampler.radius_m
        self.up = moved / np.linalg.norm(moved, axis=1)[:, None]
        self.velocity_m_s = _level(self.up, self.velocity_m_s)
        self._turn(dt)
        self.time_s = self.time_s + dt
        self._look()
        rests = self.level_m + self.aground_m
        self.height_m = rests + (self.height_m - rests) * np.exp(-dt / _LEVEL_S)

    def _look(self) -> None:
        """What the water is where a raft has come to: the next step is as long as the current there lets it be."""
        spots = self._spots()
        water = self.sampler.water(spots.reshape(-1, 3))
        depth = water.depth_m.reshape(-1, len(_SPOTS))
        wet = depth > 0.0
        some = wet.any(axis=1)
        many = np.maximum(wet.sum(axis=1), 1)
        level = np.nan_to_num(water.level_m).reshape(wet.shape).sum(axis=1) / many
        self.level_m = np.where(some, level, self.level_m)
        self.current_m_s = water.current_m_s.reshape(*wet.shape, 3).sum(axis=1) / many[:, None]
        self.depth_m = depth[:, 0]
        self._seen = spots, depth, np.where(wet, water.level_m.reshape(wet.shape), self.level_m[:, None])

    def _spots(self) -> Floats:
        """(N, 5, 3) directions."""
        port = np.cross(self.up, self.ahead)
        x, y = _SPOTS.T[..., None] / self.sampler.radius_m
        return self.up[:, None] + x * self.ahead[:, None] + y * port[:, None]

    def _middle_of_step(self, dt: Floats) -> Floats:
        """(N, 3) m/s: the current half a step ahead, by how it changed over the last (Adams and Bashforth 1883): with
        that of the step's beginning rafts would leave each bend further outside."""
        change = (self.current_m_s - self._before_m_s) * (0.5 * dt / self._before_s)[:, None]
        speed = np.linalg.norm(self.current_m_s, axis=1)
        change *= (np.linalg.norm(change, axis=1) < 0.5 * speed)[:, None]
        self._before_m_s, self._before_s = self.current_m_s, np.where(dt > 0.0, dt, np.inf)
        return self.current_m_s + change

    def _sweep(self, depth: Floats) -> Floats:
        """(N, 3) m/s towards deeper water, the more the shallower it is by the raft's length."""
        deeper = self._slope(depth)
        by_length = np.linalg.norm(deeper, axis=1) * LENGTH_M
        share = np.minimum(by_length / np.maximum(self.depth_m, DRAFT_M), 1.0)
        moving = np.linalg.norm(self.current_m_s, axis=1) > _SLOWEST_M_S
        return deeper * (_SWEEP_M_S * LENGTH_M * share * moving / np.maximum(by_length, 1e-9))[:, None]

    def _slope(self, values: Floats) -> Floats:
        """(N, 3) level: how values (N, 5) at the spots change, 1/m."""
        x, y = (values @ axis / (axis @ axis) for axis in _SPOTS.T)
        return x[:, None] * self.ahead + y[:, None] * np.cross(self.up, self.ahead)

    def _push(self, spots: Floats, depth: Floats, dt: Floats) -> Floats:
        """(N, 3) m: off the banks, so far that the ground lets go of the logs; `aground_m` where it is flat."""
        push, self.aground_m = np.zeros_like(self.up), np.zeros(len(self.up))
        raft, spot = np.nonzero(depth < 1.5 * DRAFT_M)
        if not raft.size:
            return push
        place = spots[raft, spot]
        place *= ((self.sampler.radius_m + self.level_m[raft]) / np.linalg.norm(place, axis=1))[:, None]
        sunk, normal = self.sampler.sphere_contact(place, DRAFT_M)
        sunk = np.maximum(sunk, 0.0)
        away = _level(self.up[raft], normal)
        steep = np.linalg.norm(away, axis=1)
        # Down the slope until the water there is deep enough.
        far = np.where(steep > _FLAT, np.minimum(sunk / np.maximum(steep, _FLAT), LENGTH_M), 0.0)
        np.add.at(push, raft, away / np.maximum(steep, _FLAT)[:, None] * far[:, None])
        np.add.at(self.aground_m, raft, np.minimum(sunk, DRAFT_M) / len(_SPOTS))
        # Not against the current: water piles up behind a raft on a bar until it slides over.
        way = self.current_m_s / np.maximum(np.linalg.norm(self.current_m_s, axis=1), _SLOWEST_M_S)[:, None]
        push -= way * np.minimum((push * way).sum(axis=1), 0.0)[:, None]
        length = np.linalg.norm(push, axis=1)
        return push * (np.minimum(length, np.minimum(_PUSH_M_S * dt, LENGTH_M)) / np.maximum(length, 1e-12))[:, None]

    def _slide(self, levels_m: Floats, dt: Floats) -> Floats:
        """(N, 3) m: down water that stands steeply below the raft."""
        down = -self._slope(levels_m)
        slope = np.linalg.norm(down, axis=1)
        far = np.where(slope > _STEEP, np.minimum(_PUSH_M_S * dt, LENGTH_M), 0.0)
        return down * (far / np.maximum(slope, _STEEP))[:, None]

    def _turn(self, dt: Floats) -> None:
        """The logs along the current."""
        way = _level(self.up, self.current_m_s)
        speed = np.linalg.norm(way, axis=1)
        way = way / np.maximum(speed, 1e-9)[:, None]
        angle = np.arctan2((np.cross(self.ahead, way) * self.up).sum(axis=1), (self.ahead * way).sum(axis=1))
        angle = np.where(speed > _SLOWEST_M_S, angle * (1.0 - np.exp(-dt / _TURN_S)), 0.0)
        turned = self.ahead * np.cos(angle)[:, None] + np.cross(self.up, self.ahead) * np.sin(angle)[:, None]
        self.ahead = _across(self.up, turned)


def _level(up: Floats, vectors: Floats) -> Floats:
    return vectors - up * (vectors * up).sum(axis=1)[:, None]


def _across(up: Floats, vectors: Floats) -> Floats:
    """(N, 3) unit, level."""
    level = _level(up, vectors)
    return level / np.linalg.norm(level, axis=1)[:, None]
