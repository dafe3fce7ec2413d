"""The hot loops of pictures: depth, chunks, shine, draping."""
