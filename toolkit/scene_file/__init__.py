"""Scenes as files: read from TOML, described by a JSON schema, brought to other units."""
