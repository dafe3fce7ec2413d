"""The same for a tuft of single hairs."""
