"""Starts the studio with ``python -m hapkit_studio``."""

import sys

from hapkit_studio.cli import main

sys.exit(main())
