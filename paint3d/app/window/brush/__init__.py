"""Brushes: the panel, the editor, files of one's own."""
