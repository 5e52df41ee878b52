"""Seeded sweeps for the worst case of a suite; see runner.py."""

from .runner import STRESS_SUITES, replay_file, run_sweep, usual_count

__all__ = ["STRESS_SUITES", "replay_file", "run_sweep", "usual_count"]
