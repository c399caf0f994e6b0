"""Bulk data of Nastran and OptiStruct, which are cards of ten fields: their nodes, solid or plane elements, masses and groups."""
