"""A solid of one's own on a motor: an arm that is drawn here, or any mesh."""
