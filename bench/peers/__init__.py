"""Every op of the catalog that another library has too: the spec's peer."""
