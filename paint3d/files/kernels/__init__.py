"""The hot loops of files: numbers to text, textures."""
