"""The equations of motion of the arm, as kernels."""
