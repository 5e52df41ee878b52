"""Run time beside error: the harness, its suites and the stress sweeps."""

if __name__ != "planetfall.benchmarks":
    raise ImportError("import planetfall.benchmarks, not benchmarks: two copies of each class would not know each other")
