"""What primitives are made with: lowerings and targets, argument checks, loops, module wrappers."""
