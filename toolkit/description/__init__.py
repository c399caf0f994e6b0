"""What a person writes besides bodies, joints and loads: frozen, validated records whose numbers have paths."""
