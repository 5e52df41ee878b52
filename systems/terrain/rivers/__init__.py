"""Rivers and lakes in the ground."""
