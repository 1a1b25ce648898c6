"""Running a Diagram: blocks of time, journal, pacing, progress and a clean end."""
