"""The study file: which numbers of a scene may change, what is asked of them, and every design that was solved."""
