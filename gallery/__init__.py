"""Pictures that show what the ops do (docs/gallery), and the demo: a C++ program runs bundles on
photographs."""
