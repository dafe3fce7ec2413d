"""Seals on a document, as a step of its history."""
