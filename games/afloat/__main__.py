"""`python -m planetfall.games.afloat`."""

import sys

from .main import main

sys.exit(main())
