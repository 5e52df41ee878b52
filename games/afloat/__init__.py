"""A boat and buoys that float on the sea: buoyancy by OceanSampler. On the public API only."""
