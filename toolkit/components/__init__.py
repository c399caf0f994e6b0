"""Components of a scene, a folder a kind: bodies, joints, loads, curves over time, and the markers that they meet at."""
