// What a verb says that refuses its words: exit code, identifier and a remedy.
#pragma once

#include <catch2/catch.hpp>
#include <string>

#include "tests/support/process.h"

namespace tactbench::tests {

inline void check_refusal(const Finished& finished, int code, const std::string& id) {
  INFO(finished.err);
  CHECK(finished.code == code);
  CHECK_THAT(finished.err, Catch::Contains("[" + id + "]") && Catch::Contains("\n  try: "));
}

}  // namespace tactbench::tests
