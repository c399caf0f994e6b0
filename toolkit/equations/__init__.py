"""The equations of motion of a whole scene at one state, in the compiled loop."""
