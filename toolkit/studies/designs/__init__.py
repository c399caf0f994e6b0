"""Many designs of a study, solved apart from each other at any place, and kept in one store."""
