"""Water and forests of a vector map on the ground."""
