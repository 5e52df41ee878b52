"""What makes a planet: a folder for each system, with its passes. Systems never import each other."""

if __name__ != "planetfall.systems":
    raise ImportError("import planetfall.systems, not systems: two copies of each class would not know each other")
