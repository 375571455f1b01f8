"""The tools of primitives: lowerings and targets, argument checks, loops, module wrappers."""
