"""What the stress along fibres of beams in space leaves out."""
