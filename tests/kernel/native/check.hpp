//! \file
//! As much of a test framework as the kernel needs: tests that find themselves, and checks that go on.
#pragma once

#include <cmath>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

namespace apc::test {

struct Test {
  const char* name;
  std::function<void()> run;
};

//! All tests of all files, in the order in which they register.
inline std::vector<Test>& tests() {
  static std::vector<Test> all;
  return all;
}

inline int n_failures = 0;
inline long n_checks = 0;

struct Registration {
  Registration(const char* name, std::function<void()> run) { tests().push_back({name, std::move(run)}); }
};

inline void check(bool holds, const char* what, const char* file, int line, const std::string& values = "") {
  ++n_checks;
  if (holds) return;
  // A property that fails for every random case need not be told a thousand times.
  if (++n_failures <= 20) std::printf("%s:%d: not %s %s\n", file, line, what, values.c_str());
}

inline std::string told(double a, double b) {
  char text[96];
  std::snprintf(text, sizeof text, "(%.17g, %.17g)", a, b);
  return text;
}

}  // namespace apc::test

#define APC_JOIN_(a, b) a##b
#define APC_JOIN(a, b) APC_JOIN_(a, b)

//! TEST("what holds") { ... }
#define TEST(name)                                                                                           \
  static void APC_JOIN(test_, __LINE__)();                                                                   \
  static const ::apc::test::Registration APC_JOIN(registration_, __LINE__)(name, APC_JOIN(test_, __LINE__)); \
  static void APC_JOIN(test_, __LINE__)()

#define CHECK(condition) ::apc::test::check((condition), #condition, __FILE__, __LINE__)
#define CHECK_AT_MOST(a, b) \
  ::apc::test::check((a) <= (b), #a " <= " #b, __FILE__, __LINE__, ::apc::test::told((a), (b)))
#define CHECK_NEAR(a, b, off)                                                          \
  ::apc::test::check(std::abs((a) - (b)) <= (off), #a " near " #b, __FILE__, __LINE__, \
                     ::apc::test::told((a), (b)))
#define CHECK_THROWS(expression)                                               \
  do {                                                                         \
    bool has_thrown = false;                                                   \
    try {                                                                      \
      (void)(expression);                                                      \
    } catch (const std::exception&) {                                          \
      has_thrown = true;                                                       \
    }                                                                          \
    ::apc::test::check(has_thrown, #expression " throws", __FILE__, __LINE__); \
  } while (false)
