"""The hot loop of reading: rows of numbers."""
