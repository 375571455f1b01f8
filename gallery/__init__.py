"""Pictures of what the ops do (docs/gallery), and the demo: photographs through bundles, by a C++ program."""
