"""From pointers, fingers and devices to a brush on the object, or to a camera that moves."""
