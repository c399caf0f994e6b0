"""How many floating frames bodies need: chosen by runs with other numbers of them, which also tell what they do to gradients."""
