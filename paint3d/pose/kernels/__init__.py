"""The hot loops of poses: a stroke that comes in is made ready anew with every frame."""
