"""Tiles: heights of a tree's cells that are made on the GPU, kept in slots and assembled into what is drawn."""
