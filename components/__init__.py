"""Plain dataclasses that say what a scene is made of; knobs are field metadata."""

if __name__ != "planetfall.components":
    raise ImportError("import planetfall.components, not components: two copies of each class would not know each other")
