"""``python -m apmethod``."""

import sys

from apmethod.run.main import main

sys.exit(main())
