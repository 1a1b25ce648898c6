"""The robot's supervisor: what it lets through of a command, and what it does when it does not."""
