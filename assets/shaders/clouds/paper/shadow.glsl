// Contract "cloud_shadow" (common/cloud_shadow.glsl has the rules) as printed: the transmittance towards the sun from
// one density sample in the middle of the layer (Michelic 2018, section 6), for the way through the whole of it.
#include "clouds/paper/density.glsl"

float cloud_shadow(vec3 point) {
    vec4 shell = cloud_view.shell[0];
    float altitude = altitude_of(point), mu = dot(up_at(point), frame.sun_direction.xyz);
    float middle = paper_rise(altitude, mu, 0.5 * (shell.x + shell.y));
    float way = paper_rise(altitude, mu, shell.y) - paper_rise(altitude, mu, shell.x);
    float density = max(paper_density(point + frame.sun_direction.xyz * middle + frame.camera_offset.xyz,
        0.5 * (shell.x + shell.y)), 0.0);
    return mix(1.0, exp(-shell.w * density * way), cloud_view.casts.x);
}
