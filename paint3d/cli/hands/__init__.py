"""The hands' devices on the command line: what is opened, calibrated and set."""
