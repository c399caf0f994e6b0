"""Pictures of studies of many designs."""
