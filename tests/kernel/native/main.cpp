//! \file
//! Runs every test; exit code 1 if a check of any failed.
#define DOCTEST_CONFIG_IMPLEMENT
#include <doctest/doctest.h>

int main(int argc, char** argv) {
  doctest::Context context;
  // A property that fails for every random case need not be told a thousand times.
  context.setOption("abort-after", 20);
  context.applyCommandLine(argc, argv);
  return context.run();
}
