"""A planet in a bare glfw program: no framework, its own window, loop and matrices."""
