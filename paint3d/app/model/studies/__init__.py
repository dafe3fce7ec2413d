"""The timing study of the papers: its plan, its table and its page."""
