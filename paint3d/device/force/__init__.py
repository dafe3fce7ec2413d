"""Force-feedback styli: their protocols and ports."""
