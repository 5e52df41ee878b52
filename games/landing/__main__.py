"""`python -m planetfall.games.landing`: a simple controller lands on ten places of the moon."""

import sys

from .main import main

sys.exit(main())
