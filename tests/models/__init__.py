"""Scenes, models and judges that several tests share."""
