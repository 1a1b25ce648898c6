"""What carries commands and forces between operator and robot: delays, packets, presets."""
