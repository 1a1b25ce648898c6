"""What the property tests draw from, one file a kind."""

import os

from hypothesis import settings

# SCARA_DRAKE_NIGHTLY=1 asks for the nightly profile: ten times the examples.
FACTOR = 10 if os.environ.get("SCARA_DRAKE_NIGHTLY") else 1


def examples(count: int) -> settings:
    """The settings of a property test that draws `count` examples, nightly ten times as many."""
    return settings(max_examples=count * FACTOR, deadline=None)
