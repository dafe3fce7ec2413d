"""Brushes: the panel, the editor, the user's files."""
