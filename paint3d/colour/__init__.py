"""Pigments, inks and materials, and what colour a coat of them has on what lies below."""
