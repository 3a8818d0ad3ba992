#include <cstdio>

#include "check.h"

namespace {
check::Test* first = nullptr;
const char* running = "";
int failures = 0;
}  // namespace

check::Test::Test(const char* test_name, void (*test_body)())
    : name(test_name), body(test_body), next(first) {
  first = this;
}

void check::fail(const char* file, int line, const char* what) {
  ++failures;
  std::printf("%s:%d: %s: %s\n", file, line, running, what);
}

int main() {
  int count = 0;
  for (check::Test* test = first; test; test = test->next, ++count) {
    running = test->name;
    test->body();
  }
  std::printf("%d tests, %d failures\n", count, failures);
  return failures ? 1 : 0;
}
