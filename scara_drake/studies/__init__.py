"""Studies: a scenario run many times over, and what comes of it in one dataset."""
