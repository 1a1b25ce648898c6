"""Gain tuning: the search, what it costs, and where it may look."""
