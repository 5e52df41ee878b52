// A planet's own species: what systems/cover/own_colours.py packs.
#include "cover/translucency.glsl"

uniform vec4 u_own[3 * MOST_SPECIES];

struct OwnSpecies {
    vec3 albedo, autumn;
    float leaves;        // how closed the crown is
    float translucency;
    float sheds;         // 1: its leaves turn and fall
};

// number: from 1 on; 0 is none of them, whose leaves are as others are.
OwnSpecies own_species(int number) {
    if (number == 0) return OwnSpecies(vec3(0.0), vec3(0.0), 1.0, 0.45, 0.0);
    vec4 first = u_own[3 * number - 3], second = u_own[3 * number - 2];
    return OwnSpecies(first.rgb, second.rgb, first.a, second.a, u_own[3 * number - 1].r);
}
