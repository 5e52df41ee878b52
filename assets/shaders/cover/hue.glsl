// What leaves differ by from one stand, and one species, to another: of the lightest, yellowish ones.
const vec3 HUE_TINT = vec3(0.30, 0.22, 0.08);
const float SPECIES_HUE = 0.5;   // how far few trees of a stand differ from it
