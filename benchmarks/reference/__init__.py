"""Float64 references that share no code with the library or its shaders: what errors are counted against.

Clear air: `air_medium` (parameters, densities, phase functions), `air_rays`, `air_quadrature`, `air_transmittance`,
`air_single` (single scattering).
"""
