"""One step of the servo: force, safety, state."""
