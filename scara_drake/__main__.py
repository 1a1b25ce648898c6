"""Lets `python -m scara_drake` run the command line."""

import sys

from scara_drake.cli.main import main

if __name__ == "__main__":
    sys.exit(main())
