// Contract "cloud_shadow" (common/cloud_shadow.glsl has the rules) as printed: the transmittance towards the sun from
// one density sample in the middle of the layer (Michelic 2018, section 6), for the path_m through the whole of it.
#include "clouds/paper/density.glsl"

float cloud_shadow(vec3 point) {
    CloudViewLayer shell = cloud_view.layers[0];
    float altitude = altitude_of(point), mu = dot(up_at(point), frame.sun_direction);
    float middle = paper_rise(altitude, mu, 0.5 * (shell.base_m + shell.top_m));
    float path_m = paper_rise(altitude, mu, shell.top_m) - paper_rise(altitude, mu, shell.base_m);
    float density = max(paper_density(point + frame.sun_direction * middle + frame.camera_offset_m,
        0.5 * (shell.base_m + shell.top_m), paper_level(length(point))), 0.0);
    return mix(1.0, exp(-shell.extinction_per_m * density * path_m), cloud_view.surface_shadows);
}
