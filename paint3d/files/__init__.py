"""Objects in, results out, and paintings to come back to."""
