"""`python -m planetfall.games.rolling_stones`."""

import sys

from .main import main

sys.exit(main())
