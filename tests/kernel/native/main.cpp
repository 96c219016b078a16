//! \file
//! Runs every test; exit code 1 if a check of any failed, or if there was none.
#include "check.hpp"

int main() {
  for (const apc::test::Test& test : apc::test::tests()) {
    const int before = apc::test::n_failures;
    test.run();
    std::printf("%s %s\n", apc::test::n_failures == before ? "ok    " : "FAILED", test.name);
  }
  std::printf("%zu tests, %ld checks, %d failed\n", apc::test::tests().size(), apc::test::n_checks,
              apc::test::n_failures);
  return apc::test::n_failures == 0 && apc::test::n_checks > 0 ? 0 : 1;
}
