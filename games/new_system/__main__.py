"""`python -m planetfall.games.new_system`: the ring from space and from the ground, as pictures."""

import sys

from .main import main

sys.exit(main())
