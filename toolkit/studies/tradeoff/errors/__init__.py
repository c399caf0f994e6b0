"""What settings are measured against, and how far they are off."""
