"""The flat page: pieces of fonts, drawings and files of strokes, and how it is laid on objects."""
