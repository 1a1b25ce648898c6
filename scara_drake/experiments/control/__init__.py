"""Control in the paper: Tables 10 to 12, Figures 16 to 19, 29 and 30, and what stands beside it."""
