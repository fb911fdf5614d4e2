// A verb of the fleet at a server by script.
#pragma once

#include <string>
#include <vector>

#include "bench/cli/session.h"
#include "tests/bench/cli/verb_here.h"
#include "tests/db/fleet/scripted_postgres.h"

namespace tactbench::tests::postgres {

inline std::vector<Answer> of_this_schema() { return {started(), rows(1, {{"fleet.migrations"}}), rows(1, {{"2"}})}; }

inline std::string ended(const std::string& tag) { return done(tag) + ready(); }

// `fleet` and these words, at a server that gives these answers.
inline Finished fleet_verb(const std::vector<Answer>& answers, std::vector<std::string> words,
                           std::string* where = nullptr) {
  const Server server(answers);
  if (where != nullptr) *where = server.where();
  words.insert(words.begin(), "fleet");
  words.insert(words.end(), {"--to", server.conninfo()});
  return verb_here(bench::add_fleet, words);
}

}  // namespace tactbench::tests::postgres
