"""The report: one page with everything that a run of a scene has to say. The only place besides `render` that imports matplotlib."""
