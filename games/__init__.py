"""Games on the public API only."""

if __name__ != "planetfall.games":
    raise ImportError("import planetfall.games, not games: two copies of each class would not know each other")
