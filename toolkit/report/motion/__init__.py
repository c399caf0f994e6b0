"""The moving part of a report: a view that the reader holds, an animation, pictures of space."""
