"""Where the work of a study is done: in this process, in threads of it, in processes of this machine, or on a Dask cluster."""
