"""Random numbers as functions of seeds."""
