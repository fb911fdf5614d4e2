// Runs a verb and checks its exit code, or the error that it ends with.
#pragma once

#include <catch2/catch.hpp>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/process.h"

namespace tactbench::tests {

inline std::vector<std::string> joined_arguments(std::vector<std::string> words, const std::vector<std::string>& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

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

// The JSON has these members, among others.
template <class Json>
void check_members(const Json& printed, const char* members) {
  Json with_them = printed;
  with_them.merge_patch(Json::parse(members));
  CHECK(with_them == printed);
}

}  // namespace tactbench::tests
