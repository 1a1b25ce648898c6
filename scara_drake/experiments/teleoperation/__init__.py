"""Teleoperation in the paper: Figures 20 to 28, and the couplings."""
