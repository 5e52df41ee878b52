"""Rivers and lakes found in tiles of elevation, for a vector map."""
