"""Recordings in the formats of other programs; `formats` has the list."""
