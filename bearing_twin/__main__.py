"""`python -m bearing_twin` is the command line."""

import sys

from bearing_twin.command.cli import main

sys.exit(main())
