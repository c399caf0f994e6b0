"""One search for an optimum: from which design, by which steps, and until when; above the methods, which know nothing of it."""
