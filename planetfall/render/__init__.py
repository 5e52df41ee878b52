"""Renderers: from a scene and a camera to pictures, arrays or a host's framebuffer."""
