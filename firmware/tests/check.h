// A test is written as TEST(name) { CHECK(...); }. main.cpp runs all tests and reports the lines that fail.
#pragma once

#include <cmath>

namespace check {

struct Test {
  Test(const char* test_name, void (*test_body)());

  const char* name;
  void (*body)();
  Test* next;
};

void fail(const char* file, int line, const char* what);

}  // namespace check

#define TEST(name)                                   \
  static void name();                                \
  static check::Test test_##name(#name, name); \
  static void name()

#define CHECK(condition)                                         \
  do {                                                           \
    if (!(condition)) check::fail(__FILE__, __LINE__, #condition); \
  } while (false)

#define CHECK_NEAR(a, b, tolerance) CHECK(std::fabs((a) - (b)) <= (tolerance))
