"""Uniform and storage blocks, stated without a GPU: dataclasses to std140 bytes and GLSL, and the binding points."""
