"""Lets `python -m scara_drake.replay` play a recording."""

import sys

from scara_drake.replay.player import main

sys.exit(main())
