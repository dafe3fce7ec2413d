"""From what two hands' devices say to one pose of the brush in the object's frame."""
