"""`python -m planetfall.games.embed_moderngl`."""

import sys

from .main import main

sys.exit(main())
