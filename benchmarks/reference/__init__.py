"""Float64 references that share no code with the library or its shaders: what errors are counted against.

Clear air: `air` answers the questions of the atmosphere's probe. Below it: `air_medium` (parameters, densities, phase
functions), `air_rays`, `air_quadrature`, `air_transmittance`, `air_single` (the first order), `air_multiple` (the
others, over `air_paths` and `air_tables`), `air_irradiance`. Homogeneous clouds: `cloud_shells` (single scattering, in
air too), `cloud_slab` (all orders).
"""
