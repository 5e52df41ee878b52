"""The user's own files: where they are, and reading them without ever losing them."""

from __future__ import annotations

import os
from pathlib import Path

__all__ = ["FOLDER_VARIABLE", "user_folder"]

FOLDER_VARIABLE = "PLANETFALL_CONFIG"
"""Environment variable that names another folder."""


def user_folder() -> Path:
    """Where settings of the user are kept; not made yet."""
    chosen = os.environ.get(FOLDER_VARIABLE)
    if chosen:
        return Path(chosen)
    import platformdirs

    return platformdirs.user_config_path("planetfall")
