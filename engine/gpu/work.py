"""Counters of what was asked of the GPU: tests hold "nothing to do" to zero with them."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["Work"]


@dataclass
class Work:
    """Running totals since the context was taken or reset() was called. Indirect draws count one call each."""

    draws: int = 0
    dispatches: int = 0
    uploads: int = 0
    upload_bytes: int = 0
    programs_built: int = 0

    def reset(self) -> None:
        self.draws = self.dispatches = self.uploads = self.upload_bytes = self.programs_built = 0

    def snapshot(self) -> dict[str, int]:
        return dict(vars(self))
