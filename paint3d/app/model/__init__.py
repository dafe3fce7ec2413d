"""The studio without a window: documents, the painting thread, settings, words."""
