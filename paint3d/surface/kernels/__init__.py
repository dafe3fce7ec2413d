"""The hot loops of wet ink: its graph on the surface, and its steps in time."""
