"""The certificate of the gradients, where the report has one."""

from __future__ import annotations

from toolkit.report.certificate_drawing import certificate_drawing
from toolkit.report.drawing import Drawing
from toolkit.report.material import Material


def certificate(material: Material) -> list[Drawing]:
    """Digits on which exact methods agree, and the V of the differences."""
    return [certificate_drawing(material.certificate)] if material.certificate else []
