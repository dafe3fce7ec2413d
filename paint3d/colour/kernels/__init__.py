"""The hot loops of colour: Kubelka-Munk over many vertices and bands."""
