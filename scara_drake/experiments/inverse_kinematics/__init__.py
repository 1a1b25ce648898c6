"""Inverse kinematics of the paper: Tables 5 to 9, Figures 8 to 15."""
