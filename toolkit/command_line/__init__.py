"""Parts of the command `ffrf`: what it announces, what it prints, what it inspects."""
