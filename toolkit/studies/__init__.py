"""Studies: many runs of one scene, and what they say together.

`tradeoff` is the entrance to speed against accuracy, `optimization` to the best design of a study.
"""
