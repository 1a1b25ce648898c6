"""The paper in one command: every table, figure and equation, run, judged and reported."""
