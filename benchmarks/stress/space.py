"""Stress suite space: rays, projection, coverage and the lattice, on the CPU and, for the lattice, on the GPU."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...engine.space import CameraState, pixel_rays, project, ray_sphere
from ...engine.surface.coverage import coverage
from ...engine.surface.lattice import FULL, FULL_BITS, canonical_lattice, direction_of, locate, neighbour
from ...engine.surface.lattice_anchor import LatticeAnchor
from .. import exact
from ..measure.coverage import proxy_covers
from ..measure.positions import PositionProbe
from ..session import Session
from .draw import ALTITUDES_M, RADII_M, camera, log_uniform, unit
from .runner import Case, Found, Kind


def _draw_place(rng: np.random.Generator) -> Case:
    radius = log_uniform(rng, *RADII_M)
    return {"radius_m": radius, "altitude_m": log_uniform(rng, *ALTITUDES_M), "seed": int(rng.integers(2**31))}


def _draw_ray(rng: np.random.Generator) -> Case:
    case = _draw_place(rng)
    inside = rng.random() < 0.3
    if inside:
        case["altitude_m"] = -case["radius_m"] * float(10.0 ** rng.uniform(-9.0, -0.01))
    way = rng.random()
    if way < 0.2:
        case["mu"] = float(rng.choice([-1.0, -0.0, 0.0, 1.0]))
    elif way < 0.5 and not inside:  # near the horizon's cosine, from both sides
        h, r = case["altitude_m"], case["radius_m"]
        horizon = -np.sqrt(h * (2 * r + h)) / (r + h)
        case["mu"] = float(np.clip(horizon * (1.0 + rng.normal() * 10.0 ** rng.uniform(-12.0, -2.0)), -1.0, 1.0))
    else:
        case["mu"] = float(rng.uniform(-1.0, 1.0))
    return case


def _check_ray(case: Case, session: Session) -> Found:
    """Near and far against long double; grazing rays may be called either way."""
    found = Found()
    r, h, mu = case["radius_m"], case["altitude_m"], case["mu"]
    hit = ray_sphere(h, mu, r)
    long = exact.Real
    b, c = (long(r) + long(h)) * long(mu), long(h) * (2 * long(r) + long(h))
    s2 = (1 - long(mu)) * (1 + long(mu))
    discriminant = long(r) * long(r) - (long(r) + long(h)) ** 2 * s2
    grazing = abs(discriminant) <= 1e-15 * (long(r) + abs(long(h))) ** 2
    inside = h < 0
    expected = bool(inside or (discriminant >= 0 and b < 0))
    found.expect(not np.isnan([hit.near_m, hit.far_m]).any(), "near or far is NaN")
    if not grazing:
        found.expect(bool(hit.hit) == expected, f"hit: expected {expected}, found {bool(hit.hit)}")
    if bool(hit.hit) and expected and not grazing:
        root = np.sqrt(max(discriminant, long(0)))
        q = -b - root if b >= 0 else -b + root
        roots = sorted((q, c / q)) if q != 0 else [long(0), long(0)]
        near, far = (roots[1], roots[1]) if inside else roots
        # The condition of a root: a change of the discriminant's terms in their last bit.
        margin = 1.0 + float(abs((long(r) + abs(long(h))) ** 2 / max(discriminant, long(1e-30))))
        error = max(abs(float((a - b) / (abs(b) or 1))) for a, b in ((hit.near_m, near), (hit.far_m, far)))
        found.note("error of near and far, relative to what the rounding of mu allows", error / (margin * 1e-15),
                   "", 50.0)  # fmt: skip
    return found


def _draw_projection(rng: np.random.Generator) -> Case:
    case = _draw_place(rng)
    size = [int(rng.choice([1, 2, 17, 640, 1920, 8192])), int(rng.choice([1, 3, 360, 1080, 8192]))]
    return {**case, **camera(rng, case["radius_m"], case["altitude_m"]), "size": size}


def _check_projection(case: Case, session: Session) -> Found:
    """Pixel -> ray -> point -> pixel, at all distances; axes orthonormal."""
    found = Found()
    width, height = case["size"]
    state = camera_state(case)
    axes = state.axes
    found.note("axes, from orthonormal", float(np.abs(axes @ axes.T - np.eye(3)).max()), "", 1e-14)
    rng = np.random.default_rng(case["seed"])
    pixels = np.concatenate([rng.uniform(0, 1, (30, 2)) * (width, height), [[0, 0], [width, height]]])
    rays = pixel_rays(state, (width, height), pixels)
    found.expect(bool(np.isfinite(rays).all()), "a pixel's ray is not finite")
    # Points as far as the camera's own distance from the centre: nearer ones lose digits to the large coordinates.
    distance = float(np.linalg.norm(state.position_m))
    away = distance * 10.0 ** rng.uniform(-3.0, 2.0, len(rays))
    points = state.position_m + rays * away[:, None]
    again, in_front = project(state, points, (width, height))
    found.expect(bool(in_front.all()), "a point in front of the camera is called behind it")
    pixel_rad = min((state.tan_top - state.tan_bottom) / height, (state.tan_right - state.tan_left) / width)
    rounding_px = 4e-16 * (1.0 + distance / away) / pixel_rad * (1.0 + max(abs(state.tan_top), abs(state.tan_right),
                           abs(state.tan_left), abs(state.tan_bottom)) ** 2)  # fmt: skip
    error = np.linalg.norm(again - pixels, axis=1)
    share = float((error / (rounding_px + 1e-11)).max())
    found.note("round trip, relative to the rounding of the points", share, "", 50)
    return found


def _draw_coverage(rng: np.random.Generator) -> Case:
    case = _draw_place(rng)
    r = case["radius_m"]
    case["altitude_m"] = 0.0 if rng.random() < 0.1 else case["altitude_m"]
    case["highest_m"] = 0.0 if rng.random() < 0.2 else 0.1 * r * float(10.0 ** rng.uniform(-6.0, 0.0))
    case["lowest_m"] = 0.0 if rng.random() < 0.2 else -0.1 * r * float(10.0 ** rng.uniform(-6.0, 0.0))
    return case


def _check_coverage(case: Case, session: Session) -> Found:
    """The covered arc, and that a proxy's grid holds the peaks at the limit of its cameras' sight."""
    found = Found()
    r, a, high, low = (case[k] for k in ("radius_m", "altitude_m", "highest_m", "lowest_m"))
    arc = coverage(a, r, high, low)
    half = min(float(exact.visible_half_angle(a - low, r + low, high - low)), np.pi)
    found.expect(bool(np.isfinite((arc.half_angle_rad, arc.z_s, arc.grid_offset)).all()), "z_s is not finite")
    found.note("covered arc, from exact", abs(arc.half_angle_rad - half), "r", 1e-9)
    found.note("arc of z_s, from exact", abs(float(np.arctan2(1.0, arc.z_s)) - half), "r", 1e-9)
    covered = proxy_covers(r, max(a, 0.01), high, low, np.random.default_rng(case["seed"]), 8)
    found.note("seen beyond the proxy's grid", covered.worst_missing_r, "r", 1e-9)
    found.expect(covered.outside == 0, f"{covered.outside} of {covered.points} peaks at the limit lie in no cell")
    return found


def _draw_lattice(rng: np.random.Generator) -> Case:
    return {**_draw_place(rng), "direction": unit(rng)}


def _check_lattice(case: Case, session: Session) -> Found:
    """locate inverts direction_of; border points have one name; neighbours touch; offsets keep their digits."""
    found = Found()
    rng = np.random.default_rng(case["seed"])
    face = rng.integers(0, 6, 200)
    special = np.array([0, 1, FULL // 2, FULL - 1, FULL])
    i, j = (np.where(rng.random(200) < 0.4, rng.choice(special, 200), rng.integers(0, FULL + 1, 200)) for _ in "ij")
    truth = exact.lattice_direction(face, i, j)
    found.note("direction, from exact", float(np.abs(direction_of(face, i, j) - truth).max()), "", 5e-16)
    names = canonical_lattice(face, i, j)
    same = direction_of(*names) == direction_of(face, i, j)
    found.expect(bool(same.all()), "a border point's names differ in bits")
    where = locate(direction_of(*names))
    interior = (names[1] > 0) & (names[1] < FULL) & (names[2] > 0) & (names[2] < FULL)
    off = np.maximum(np.abs(where[1] - names[1]), np.abs(where[2] - names[2]))[interior & (where[0] == names[0])]
    found.note("locate, from the lattice point", float(off.max(initial=0.0)), "steps", 1e-5)
    level = int(rng.integers(0, FULL_BITS + 1))
    ci, cj = rng.integers(0, 1 << level, (2, 50))
    cf, edge = rng.integers(0, 6, 50), rng.integers(0, 4, 50)
    nf, ni, nj = neighbour(cf, level, ci, cj, edge)
    back = np.zeros(50, bool)
    for e in range(4):
        bf, bi, bj = neighbour(nf, level, ni, nj, np.full(50, e))
        back |= (bf == cf) & (bi == ci) & (bj == cj)
    found.expect(bool(back.all()), f"a neighbour on level {level} is not a neighbour the other way round")
    anchor = LatticeAnchor(case["direction"], case["radius_m"])
    exact_offset = (truth - exact.lattice_direction(anchor.face, anchor.i, anchor.j)) * exact.Real(case["radius_m"])
    size = np.sqrt((exact_offset * exact_offset).sum(axis=1)).astype(float)
    error = np.sqrt(((anchor.foot_offset64(face, i, j) - exact_offset) ** 2).sum(axis=1)).astype(float)
    # What long double itself loses in the difference of two unit vectors is taken off.
    relative = np.maximum(error - 4e-19 * case["radius_m"], 0.0) / np.maximum(size, 1e-9)
    found.note("f64 foot offset, relative", float(relative.max()), "", 2e-15)
    return found


def _check_positions(case: Case, session: Session) -> Found:
    """The worst vertex of a flat planet on screen; the GPU's part of the suite."""
    found = Found()
    with PositionProbe(session.gpu) as probe:
        worst = probe.measure(case["radius_m"], case["altitude_m"], np.random.default_rng(case["seed"]), 8000)
    found.expect(worst.not_finite == 0, f"{worst.not_finite} vertices are not finite")
    # Camera positions themselves are f64: their last bit, seen from 1 cm, is more than the renderer may add.
    given_px = 4e-16 * (case["radius_m"] + case["altitude_m"]) / case["altitude_m"] / 1.07e-3
    found.note("undisplaced vertex, on screen", worst.worst_px, "px", 1e-3 + given_px)
    return found


def camera_state(case: Case) -> CameraState:
    """The camera of a case."""
    if "frustum_deg" in case:
        return CameraState.frustum_deg(case["position_m"], case["forward"], case["up"], tuple(case["frustum_deg"]))
    width, height = case.get("size", (16, 9))
    return CameraState.look(case["position_m"], case["forward"], case["up"], case["fov_y_deg"], width / height)


KINDS: Mapping[str, Kind] = {
    "ray": Kind(_draw_ray, _check_ray, 4.0),
    "projection": Kind(_draw_projection, _check_projection, 3.0),
    "coverage": Kind(_draw_coverage, _check_coverage, 1.0),
    "lattice": Kind(_draw_lattice, _check_lattice, 1.0),
    "positions": Kind(_draw_place, _check_positions, 1.0),
}
