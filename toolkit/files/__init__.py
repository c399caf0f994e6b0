"""Files that a run reads and writes: scenes with their schema, results, tables."""
