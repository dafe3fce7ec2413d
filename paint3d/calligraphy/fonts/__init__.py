"""Text in fonts: files and names of fonts, shaping, lines, and pieces of ink in writing order."""
