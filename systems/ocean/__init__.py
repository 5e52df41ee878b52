"""ocean."""
