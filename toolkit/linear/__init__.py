"""Linear systems: sparse factors on a static pattern, dense ones with pivoting, and the choice between them."""
