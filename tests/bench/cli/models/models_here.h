// Runs the verbs on models within the test's process, with the files of one folder.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "tests/bench/cli/verb_here.h"

namespace tactbench::tests {

inline std::string without_folder(std::string text, const TemporaryFolder& folder) {
  const std::string path = folder.path() + "/";
  for (std::size_t at = text.find(path); at != std::string::npos; at = text.find(path, at)) text.erase(at, path.size());
  return text;
}

// fit, model, predict or compensate: words that end as names of files do are files of the folder, and so they stand in
// what is said. The store is the folder's runs.db.
inline Finished model_verb(const TemporaryFolder& folder, std::vector<std::string> words) {
  const std::string verb = words.front();
  for (std::string& word : words)
    for (const char* end : {".json", ".csv", ".toml"})
      if (word.ends_with(end) && !word.starts_with('/')) word = folder.path(word);
  words.insert(words.end(), {"--db", folder.path("runs.db")});
  Finished finished = verb_here(verb == "fit"       ? bench::add_fit
                                : verb == "compare" ? bench::add_compare
                                : verb == "model"   ? bench::add_model
                                                    : bench::add_predict,
                                std::move(words));
  finished.out = without_folder(finished.out, folder);
  finished.err = without_folder(finished.err, folder);
  return finished;
}

}  // namespace tactbench::tests
