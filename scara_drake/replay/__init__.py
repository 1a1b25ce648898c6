"""Plays a recording without Drake: see `player`."""
