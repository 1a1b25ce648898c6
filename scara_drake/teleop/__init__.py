"""Teleoperation: joystick, command mapping, delayed channel and haptics."""
