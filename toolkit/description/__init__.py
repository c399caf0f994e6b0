"""Descriptions of all but bodies, joints and loads: frozen, validated records whose numbers have paths."""
