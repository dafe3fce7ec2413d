"""From text to strokes: glyphs, layout, and the planning of the motion that writes them."""
