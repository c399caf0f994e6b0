"""An extension of griffe, which reads the code for the reference: comments behind the fields of a class are their descriptions."""

from __future__ import annotations

import griffe

from docs.generators.comments import trailing_comment


class TrailingComments(griffe.Extension):
    """Give an attribute without docstring the comment on its line."""

    def on_attribute_instance(self, *, attr: griffe.Attribute, **_: object) -> None:
        """Called for every attribute that is found in a source file."""
        if attr.docstring is None and attr.lineno is not None and attr.endlineno is not None:
            comment = trailing_comment("\n".join(attr.lines_collection[attr.filepath][attr.lineno - 1 : attr.endlineno]))
            if comment:
                attr.docstring = griffe.Docstring(comment, lineno=attr.lineno, parent=attr)
