"""The sheet of VTK that space is drawn on: panels, letters, layout."""
