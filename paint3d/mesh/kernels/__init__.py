"""The hot loops of meshes: trees, lattices, refinement, topology."""
