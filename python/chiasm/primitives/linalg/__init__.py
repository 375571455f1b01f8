"""Small matrices and polynomials in arithmetic only, without a library."""
