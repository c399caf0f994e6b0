"""The commands of `ffrf`, one per file."""
