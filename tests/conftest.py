"""What every test can count on."""

import signal


def pytest_configure() -> None:
    """Let Ctrl-C be heard, in child processes too; a shell in the background ignores it."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
