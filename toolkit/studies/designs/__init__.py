"""Designs of a study: each solved in all cases, many side by side, and judged."""
