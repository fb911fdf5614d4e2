// A temporary store of a test, and verbs run on it within the test's process.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "tests/bench/cli/verb_here.h"
#include "tests/db/store_example.h"

namespace tactbench::tests {

struct StoreHere {
  Finished say(AddVerb add, std::vector<std::string> words) const {
    words.insert(words.end(), {"--db", path});
    return verb_here(add, std::move(words));
  }
  template <class Json>
  [[nodiscard]] Json printed(AddVerb add, std::vector<std::string> words) const {
    words.emplace_back("--json");
    return Json::parse(say(add, std::move(words)).out);
  }
  [[nodiscard]] db::RunStore open() const { return db::RunStore::open(path, db::Durability::kNormal); }
  TemporaryFolder folder;
  std::string path = folder.path("runs.db");
};

struct OpenStoreHere : StoreHere {
  db::RunStore store = open();
};

}  // namespace tactbench::tests
