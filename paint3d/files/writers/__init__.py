"""Writing painted objects, format by format."""
