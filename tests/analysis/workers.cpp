// Work shared out by index: all of it is done, whatever fails, and the first failure is told.
#include "analysis/workers.h"

#include <catch2/catch.hpp>
#include <stdexcept>
#include <string>
#include <vector>

using namespace tactbench::analysis;

TEST_CASE("for_each_index: runs each index once even if others fail, and throws the failure of the lowest index") {
  std::vector<int> times(5, 0);
  for_each_index(5, 1, [&](std::size_t i) { ++times[i]; });
  CHECK(times == std::vector<int>(5, 1));
  for_each_index(0, 1, [](std::size_t) { FAIL("there is none"); });
  const auto failing = [&](std::size_t i) {
    ++times[i];
    if (i == 1 || i == 3) throw std::runtime_error(std::to_string(i));
  };
  CHECK_THROWS_WITH(for_each_index(5, 1, failing), "1");
  CHECK(times == std::vector<int>(5, 2));
}

TEST_CASE("work progress: counts the outer work, not work nested in it") {
  const std::size_t before = work_now().works;
  std::vector<std::size_t> done;
  for_each_index(3, 1, [&](std::size_t) {
    done.push_back(work_now().done);
    CHECK(work_now().count == 3);
    for_each_index(7, 1, [](std::size_t) { CHECK(work_now().count == 3); });
  });
  CHECK(done == std::vector<std::size_t>{0, 1, 2});
  CHECK(work_now().works == before + 1);
  CHECK(work_now().count == 0);
  for_each_index(2, 1, [](std::size_t) {});
  CHECK(work_now().works == before + 2);
}
