"""Many paintings from a table: rows, workers, job files."""
