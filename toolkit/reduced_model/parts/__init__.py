"""Parts of a reduced model that some bodies have and others do not."""
