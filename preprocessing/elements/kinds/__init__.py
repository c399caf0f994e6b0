"""Kinds of finite elements, one record each: a new kind is a file here, and what assembles, reduces and stores bodies knows no kind."""
