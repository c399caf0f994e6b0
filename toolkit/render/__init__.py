"""Pictures: of the plane by matplotlib, of space by VTK, and series for ParaView; the only place besides `report` that draws."""
