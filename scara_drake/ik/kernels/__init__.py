"""Compiled kernels of the inverse kinematics."""
