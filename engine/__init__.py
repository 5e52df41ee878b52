"""The engine: GPU, entity world, frame graph, spheres and double-precision space. Knows no planet."""

if __name__ != "planetfall.engine":
    raise ImportError("import planetfall.engine, not engine: two copies of each class would not know each other")
