//! \file
//! Runs every test; exit code 1 if a check of any failed, or if no test was run.
#define DOCTEST_CONFIG_IMPLEMENT
#include <doctest/doctest.h>

#include <iostream>

namespace {

unsigned n_run = 0;

//! Counts the test cases of a run: to doctest a run without any is a success.
class Counter : public doctest::IReporter {
 public:
  explicit Counter(const doctest::ContextOptions&) {}
  void test_run_end(const doctest::TestRunStats& run) override { n_run = run.numTestCasesPassingFilters; }

  void report_query(const doctest::QueryData&) override {}
  void test_run_start() override {}
  void test_case_start(const doctest::TestCaseData&) override {}
  void test_case_reenter(const doctest::TestCaseData&) override {}
  void test_case_end(const doctest::CurrentTestCaseStats&) override {}
  void test_case_exception(const doctest::TestCaseException&) override {}
  void subcase_start(const doctest::SubcaseSignature&) override {}
  void subcase_end() override {}
  void log_assert(const doctest::AssertData&) override {}
  void log_message(const doctest::MessageData&) override {}
  void test_case_skipped(const doctest::TestCaseData&) override {}
};

REGISTER_LISTENER("counter", 1, Counter);

}  // namespace

int main(int argc, char** argv) {
  doctest::Context context;
  // A property that fails for every random case need not be told a thousand times.
  context.setOption("abort-after", 20);
  context.applyCommandLine(argc, argv);
  const int code = context.run();
  if (context.shouldExit() || n_run > 0) return code;  // or what was asked for is a list of tests
  std::cerr << "no test was run: none is built in, or none has the name that was asked for\n";
  return 1;
}
