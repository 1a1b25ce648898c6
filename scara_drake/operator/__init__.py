"""Who commands, and what he feels: joystick, master, recorded motions, haptics."""
