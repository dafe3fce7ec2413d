"""Sessions and journals: a painting with its way back."""
