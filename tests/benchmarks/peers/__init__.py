"""The same scenes here and in Exudyn, in one interleaved run, error beside time: `python -m tests.benchmarks.peers`.

Needs `pip install '.[all,peers]'` (Exudyn). Every scene is one file with both its statements; all times are CPU time of the motion alone.
"""
