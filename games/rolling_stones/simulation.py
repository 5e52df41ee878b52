"""Stones in a physics engine (Rapier, https://rapier.rs) on patches of the planet's ground.

The engine works in single precision, so it works in a local frame: its origin is a point near the stones, and moves on
when they have rolled away from it. Ground is TerrainSampler.patch: pieces of the planet's lattice around the stones,
the same whatever a camera sees, made before a stone gets there.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import rapier3d as rapier
from numpy.typing import NDArray

import planetfall as pf

from .frame import LocalFrame, inverse, product

Floats = NDArray[np.float64]

GRAVITY_M_S2 = 9.81
STEP_S = 1.0 / 240.0
PATCH_M, SPACING_M = 38.0, 0.3
"""128 quads of 0.3 m: the ground's finest bumps are 4 m wide, triangles miss them by a millimetre or two; twice as wide
they miss them by up to a centimetre."""
BORDER = 5
"""Patches overlap by rings of quads, wider than the largest stone's radius, so that no stone on one patch touches the
open edge of the next: without, balls of 1 m change their speed there by 0.07 to 0.3 m/s."""
_LOOK_AHEAD_S = 0.4
_MARGIN_M = 3.0
_KEEP_S = 3.0
_FARTHEST_M = 400.0
"""How far the stones' middle may be from the frame's origin: 0.03 mm is a step of f32 there."""
_DRAG_PER_S = 0.012
_PREDICTION_M = 0.1
"""Contacts are seen coming from so far: a stone that lands is stopped at the ground, not below it."""
_STIFFNESS_HZ = 240.0
"""Of contacts with the ground; the engine's own 60 lets fast stones sink by centimetres."""
_GROUND_EVERY = 8


@dataclass
class _Piece:
    """One patch of ground: the engine's collider, its points in planet axes, when it was last needed."""

    collider: Any
    points_m: Floats
    needed_s: float


class RollingStones:
    """N balls of stone on the ground of a planet; positions are planet-centred metres in planet axes throughout.

    sampler: the ground. positions_m: centres (N, 3). radii_m: (N,). velocities_m_s: (N, 3), rolling already.
    """

    def __init__(
        self, sampler: pf.TerrainSampler, positions_m: Floats, radii_m: Floats, velocities_m_s: Floats
    ) -> None:
        self.sampler, self.radii_m = sampler, np.asarray(radii_m, dtype=np.float64)
        self.frame = LocalFrame.at(positions_m.mean(axis=0))
        self.time_s = 0.0
        self._steps = 0
        self.patches_made = self.frames_used = 0
        self._pieces: dict[tuple[int, ...], _Piece] = {}
        self._triangles: Any = None
        self._world: Any = rapier.PhysicsWorld(gravity=(0.0, 0.0, -GRAVITY_M_S2))
        self._world.integration_parameters.dt = STEP_S
        self._world.integration_parameters.static_contact_softness = rapier.SpringCoefficients(_STIFFNESS_HZ, 10.0)
        local, speed = self.frame.to_local(positions_m), velocities_m_s @ self.frame.axes.T
        # Without slip: the lowest point stands still.
        spin = np.cross([0.0, 0.0, 1.0], speed) / self.radii_m[:, None]
        self._bodies = [
            self._world.add_body(
                rapier.RigidBody.dynamic()
                .translation(tuple(place))
                .linvel(tuple(v))
                .angvel(tuple(w))
                .linear_damping(_DRAG_PER_S)
                .can_sleep(False)
                .soft_ccd_prediction(_PREDICTION_M),
                [rapier.Collider.ball(float(radius)).density(2600.0).friction(0.9).restitution(0.0)],
            )
            for place, v, w, radius in zip(local, speed, spin, self.radii_m, strict=True)
        ]
        self._states: list[Any] = [self._world.rigid_bodies[handle] for handle in self._bodies]
        self._read()
        self._ground()

    # -- what they do -------------------------------------------------------------------------------------------------

    def step(self) -> None:
        """STEP_S further."""
        if np.linalg.norm(self._local.mean(axis=0)) > _FARTHEST_M:
            self.move_frame()
        if self._steps % _GROUND_EVERY == 0:
            self._ground()
        self._steps += 1
        up = self.frame.to_planet(self._local.mean(axis=0)[None])[0]
        down = -GRAVITY_M_S2 * (self.frame.axes @ (up / np.linalg.norm(up)))
        self._world.gravity = tuple(down)
        self._world.step()
        self.time_s += STEP_S
        self._read()

    @property
    def positions_m(self) -> Floats:
        return self.frame.to_planet(self._local)

    @property
    def velocities_m_s(self) -> Floats:
        """(N, 3) in planet axes."""
        return self._speed @ self.frame.axes

    @property
    def orientations(self) -> Floats:
        """Quaternions (N, 4) (x, y, z, w) from the stones' axes to the planet's."""
        return product(self.frame.quaternion, np.array([s.rotation.to_tuple() for s in self._states]))

    @property
    def depths_m(self) -> Floats:
        """(N,) how deep each stone is in the ground as TerrainSampler has it: negative in the air."""
        return self.sampler.sphere_contact(self.positions_m, self.radii_m)[0]

    def patch_of(self, positions_m: Floats) -> NDArray[np.int64]:
        """Rows (N, 4) that name the patch of ground below each place."""
        return self.sampler.patch_cells(positions_m, PATCH_M, SPACING_M)

    # -- the engine ---------------------------------------------------------------------------------------------------

    def _read(self) -> None:
        self._local = np.array([s.translation.to_tuple() for s in self._states], dtype=np.float64)
        self._speed = np.array([s.linvel.to_tuple() for s in self._states], dtype=np.float64)

    def _ground(self) -> None:
        """Patches below the stones, around them and where they will be soon."""
        reach = _MARGIN_M + self.radii_m.max()
        around = np.array([[x, y, 0.0] for x in (-reach, 0.0, reach) for y in (-reach, 0.0, reach)])
        soon = self._local + _LOOK_AHEAD_S * self._speed
        places = (np.concatenate([self._local, soon])[:, None] + around).reshape(-1, 3)
        planet = self.frame.to_planet(places)
        cells, first = np.unique(self.patch_of(planet), axis=0, return_index=True)
        for cell, k in zip(map(tuple, cells.tolist()), first, strict=True):
            piece = self._pieces.get(cell)
            if piece is None:
                points = self._points(planet[k])
                piece = self._pieces[cell] = _Piece(self._collider(points), points, self.time_s)
                self.patches_made += 1
            piece.needed_s = self.time_s
        for cell, piece in list(self._pieces.items()):
            if piece.needed_s < self.time_s - _KEEP_S:
                self._world.remove_collider(piece.collider)
                del self._pieces[cell]

    def _points(self, direction: Floats) -> Floats:
        """Of the patch that holds a direction: (n^2, 3) planet-centred metres."""
        origin = (np.zeros(3), np.eye(3))  # the planet's own axes: neighbours share their points to the last bit
        patch = self.sampler.patch(
            direction, PATCH_M, SPACING_M, aligned=True, border=BORDER, normals=False, frame=origin
        )
        if self._triangles is None:
            self._triangles = patch.triangles().astype(np.uint32)
        return patch.positions_m.reshape(-1, 3)

    def _collider(self, points_m: Floats) -> Any:
        local = self.frame.to_local(points_m).astype(np.float32)
        shape = rapier.Collider.trimesh(local, self._triangles, rapier.TriMeshFlags.FIX_INTERNAL_EDGES)
        return self._world.add_collider(shape.friction(0.9).restitution(0.0))

    def move_frame(self) -> None:
        """A new frame below the stones: the same places, velocities and turns in other coordinates."""
        positions, speeds = self.positions_m, self.velocities_m_s
        spins = np.array([s.angvel.to_tuple() for s in self._states], dtype=np.float64) @ self.frame.axes
        turns = self.orientations
        self.frame = LocalFrame.at(positions.mean(axis=0))
        self.frames_used += 1
        local, axes = self.frame.to_local(positions), self.frame.axes
        turns = product(inverse(self.frame.quaternion), turns)
        for body, place, turn, v, w in zip(self._states, local, turns, speeds @ axes.T, spins @ axes.T, strict=True):
            body.translation, body.rotation = tuple(place), tuple(turn)
            body.linvel, body.angvel = tuple(v), tuple(w)
        for piece in self._pieces.values():
            self._world.remove_collider(piece.collider)
            piece.collider = self._collider(piece.points_m)
        self._read()


def on_slope(
    sampler: pf.TerrainSampler, direction: Floats, count: int, speed_m_s: float = 8.0, seed: int = 1
) -> RollingStones:
    """`count` stones of 0.5 to 1.2 m radius in rows across the slope at a place, about to roll down it."""
    rng = np.random.default_rng(seed)
    up = np.asarray(direction, dtype=np.float64)
    normal = sampler.normal(up[None], footprint_m=300.0)[0]
    downhill = normal - up * (normal @ up)
    downhill /= np.linalg.norm(downhill)
    across = np.cross(up, downhill)
    columns = 25
    k = np.arange(count)
    x = (k % columns - 0.5 * (columns - 1)) * 4.0 + rng.uniform(-0.5, 0.5, count)
    y = (k // columns) * 5.0 + rng.uniform(-0.5, 0.5, count)
    radii = rng.uniform(0.5, 1.2, count)
    feet = up * sampler.radius_m + x[:, None] * across + y[:, None] * downhill
    feet /= np.linalg.norm(feet, axis=1)[:, None]
    centers = feet * (sampler.radius_m + sampler.height(feet) + radii)[:, None]
    depth, out = sampler.sphere_contact(centers, radii)
    centers = centers + out * np.maximum(depth, 0.0)[:, None]
    ground = sampler.normal(feet)
    way = downhill - ground * (ground @ downhill)[:, None]
    way /= np.linalg.norm(way, axis=1)[:, None]
    return RollingStones(sampler, centers, radii, way * speed_m_s)
