"""`python -m vibopt` is the command line."""

import sys

from vibopt.cli.main import main

sys.exit(main())
