"""A red team: searches a bilateral scenario for the largest harm, and shrinks what it finds."""
