"""`python -m dct_harness`: the command where no folder of scripts is on the path."""

import sys

from dct_harness.cli import main

sys.exit(main())
