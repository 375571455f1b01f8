/* The engine library that the fake torch backend needs, and which it cannot find. */
int fake_engine_function(void);

int fake_engine_function(void) { return 0; }
