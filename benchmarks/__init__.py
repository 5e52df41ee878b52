"""Run time beside error: the harness, its suites and the stress sweeps."""

if __name__ != "planetfall.benchmarks":
    raise ImportError("import planetfall.benchmarks, not benchmarks: there would be two copies of each class")
