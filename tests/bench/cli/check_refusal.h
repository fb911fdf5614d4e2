// What a verb ends with: the exit code that it should have, or a refusal.
#pragma once

#include <catch2/catch.hpp>
#include <string>
#include <utility>

#include "tests/support/process.h"

namespace tactbench::tests {

// Identifier, place (where one is given) and a remedy.
inline void check_refusal(const Finished& finished, int code, const std::string& id, const std::string& place = {}) {
  INFO(finished.err);
  CHECK(finished.code == code);
  CHECK_THAT(finished.err, Catch::Contains("[" + id + "]\n" + (place.empty() ? "" : "  at: " + place + "\n")) &&
                               Catch::Contains("\n  try: "));
}

// The same, once it ended so.
inline Finished well(Finished finished, int code = 0) {
  INFO(finished.out << finished.err);
  REQUIRE(finished.code == code);
  return finished;
}

}  // namespace tactbench::tests
