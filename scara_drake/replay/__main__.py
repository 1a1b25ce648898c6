"""Lets `python -m scara_drake.replay` play a recording."""

import signal
import sys

from scara_drake.replay.player import main

signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))  # so that the server is ended too
sys.exit(main())
