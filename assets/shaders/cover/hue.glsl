// What leaves differ by from one stand, and one species, to another: of the lightest, yellowish ones.
const vec3 HUE_TINT = vec3(0.26, 0.21, 0.13);
const float SPECIES_HUE = 0.5;   // how far few trees of a stand differ from it
