"""An object with ink on it: wet, dried, in layers, and the way back."""
