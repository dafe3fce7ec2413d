"""What the hand does over the picture."""
