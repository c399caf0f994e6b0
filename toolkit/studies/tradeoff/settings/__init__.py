"""What a study varies, and what it keeps of each setting."""
