"""Files of other programs: read by the libraries that know their formats, in a process of its own that may fail in any way."""
