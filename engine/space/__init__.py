"""Double-precision space: cameras, axes, projection, frustum, rays and horizon. The only door from f64 to f32."""

from .axes import direction, heading_pitch_axes, latitude_longitude, local_axes, orthonormal_axes
from .camera import CameraState
from .cone import least_angle_rad, least_elevation_rad, sphere_unseen
from .errors import SpaceError
from .frustum import frustum_planes, out_of_view, sphere_outside
from .horizon import horizon_angle_rad, horizon_dip_rad, horizon_distance_m, sight_distance_m
from .projection import near_plane_m, pixel_rays, project, projection_terms
from .rays import SphereHit, ray_sphere, ray_sphere_from
from .vectors import cross, length

__all__ = [
    "CameraState",
    "SpaceError",
    "SphereHit",
    "cross",
    "direction",
    "frustum_planes",
    "heading_pitch_axes",
    "horizon_angle_rad",
    "horizon_dip_rad",
    "horizon_distance_m",
    "latitude_longitude",
    "least_angle_rad",
    "least_elevation_rad",
    "length",
    "local_axes",
    "near_plane_m",
    "orthonormal_axes",
    "out_of_view",
    "pixel_rays",
    "project",
    "projection_terms",
    "ray_sphere",
    "ray_sphere_from",
    "sight_distance_m",
    "sphere_outside",
    "sphere_unseen",
]
