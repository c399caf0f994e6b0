"""The best design of a study: searches from several starts, and what an optimum has to stand before it is called one."""
