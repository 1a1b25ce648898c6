"""What is kept of a run: names of signals, the recorder, labelled datasets, files."""
