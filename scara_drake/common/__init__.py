"""What every room needs and no robot is known in: checks, schemas, state, draws, files."""
