"""Markers: points of bodies with an orientation, through which joints and loads see every body."""
