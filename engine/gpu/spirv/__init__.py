"""What a reference compiler says about shaders, for authors and tests: nothing of it runs in a game.

`compiler` makes SPIR-V of a stage's text or says what is wrong with it; `module` reads SPIR-V; `access` finds what a
stage reads and writes; `lint` and `names` refuse what compiles here and fails elsewhere.
"""

from .access import Access, accesses
from .compiler import ReferenceCompiler
from .lint import faults
from .module import Module
from .usage import usage

__all__ = ["Access", "Module", "ReferenceCompiler", "accesses", "faults", "usage"]
