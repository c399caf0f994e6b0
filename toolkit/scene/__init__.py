"""Scenes: points, bodies, joints, loads, design variables and wanted responses under one roof."""
