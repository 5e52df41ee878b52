"""Planetfall: whole planets for Python, from 36 000 km out down to a beach."""

from pathlib import Path as _Path

from ._version import __version__

# In a checkout the library's folders (engine, systems, components, assets, games, benchmarks) lie beside this one; in an
# installed wheel they lie inside it. Either way they are imported as planetfall.engine and so on.
_root = _Path(__file__).resolve().parent
if not (_root / "engine").is_dir():
    __path__.append(str(_root.parent))
ASSETS = (_root if (_root / "assets").is_dir() else _root.parent) / "assets"

__all__ = ["ASSETS", "__version__"]
