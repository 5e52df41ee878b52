"""Real elevation from files: tiles, their index, pyramids of pages, and exact heights between the samples."""
