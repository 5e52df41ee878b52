"""`python -m planetfall.games.demo_planet`."""

import sys

from .main import main

sys.exit(main())
