"""What there is to paint with: lists that commands print."""
