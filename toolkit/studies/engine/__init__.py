"""The engine of all studies: jobs run in threads, in processes or on a Dask cluster, and their outcomes kept in a store."""
