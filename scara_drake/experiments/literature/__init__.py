"""Results that others have published, as experiments with claims: a file each."""
