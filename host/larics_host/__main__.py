"""`python -m larics_host` is `larics`."""

import sys

from larics_host.cli import main

sys.exit(main())
