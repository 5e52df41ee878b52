// The tree's axes in planet axes: columns. Any two level ones do, turned.
mat3 tree_axes(vec3 up, float turn) {
    vec3 helper = abs(up.z) < 0.7 ? vec3(0.0, 0.0, 1.0) : vec3(1.0, 0.0, 0.0);
    vec3 x = normalize(cross(helper, up)), y = cross(up, x);
    float angle = 6.2831853 * turn, c = cos(angle), s = sin(angle);
    return mat3(c * x + s * y, c * y - s * x, up);
}
