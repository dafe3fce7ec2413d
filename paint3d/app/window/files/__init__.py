"""Opening, saving, exporting, and bringing back what a crash left."""
