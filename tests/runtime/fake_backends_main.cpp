/** The main of tests that load bundles on the fake backends. */
#include <gmock/gmock.h>

#include <cstdlib>

int main(int argc, char** argv) {
  ::setenv("CHIASM_BACKEND_PATH", CHIASM_FAKE_FOLDER "/good", 1);
  ::testing::InitGoogleMock(&argc, argv);
  return RUN_ALL_TESTS();
}
