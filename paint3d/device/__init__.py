"""What hands hold: reports in, readings out, and forces back."""
