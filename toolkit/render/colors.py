"""Colours that pictures in the plane and in space share."""

UNDEFORMED, TARGET, ROD, SUPPORT = "#707070", "#1a8f3c", "#8fa3bf", "#7a4a1e"
INK, FRAME, BODY = "#202020", "#808080", "#3d5478"
