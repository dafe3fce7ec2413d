"""The formats of files: each reads and writes, and shares its tables."""
