"""Pictures of the painted object: offscreen, and live in chunks."""
