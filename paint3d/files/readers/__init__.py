"""Reading meshes and their looks, format by format."""
