"""The painter: runs recordings and live hands through the brush engine onto a surface."""
