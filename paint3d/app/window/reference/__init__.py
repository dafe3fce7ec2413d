"""The reference: a picture beside the work, over it, or laid on the object."""
