"""The object that is painted on: how it stands, and what it is made of."""
