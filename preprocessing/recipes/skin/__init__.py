"""skin.toml: a skin round the nose of an airfoil."""
