"""Time series for ParaView: deformed bodies with stress and its derivatives, and the mechanism; written by VTK without a screen."""
