"""From an ink shape to strokes: regions and centre lines in order and direction of writing."""
