"""Random damage to every kind of file that paint3d reads; see `python -m scripts.fuzz --help`."""
