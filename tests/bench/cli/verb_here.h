// Runs a verb within the test's process: fast, and a fault in it is the test's own. `call` of tests/support/process.h
// starts the program instead.
#pragma once

#include <fcntl.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "bench/cli/session.h"
#include "tests/db/store_example.h"
#include "tests/support/process.h"
#include "tests/support/text.h"

namespace tactbench::tests {

// Runs a verb and checks its exit code, or the error that it ends with.

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

// Text written to a stream of the process within the object's scope.
class Captured {
 public:
  explicit Captured(std::FILE* stream) : stream_(stream) {
    std::fflush(stream_);
    kept_ = ::dup(::fileno(stream_));
    const int file = ::open(folder_.path("text").c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    ::dup2(file, ::fileno(stream_));
    ::close(file);
  }
  ~Captured() { end(); }
  Captured(const Captured&) = delete;
  Captured& operator=(const Captured&) = delete;
  std::string text() {
    end();
    return read_file(folder_.path("text"));
  }

 private:
  void end() {
    if (kept_ < 0) return;
    std::fflush(stream_);
    ::dup2(kept_, ::fileno(stream_));
    ::close(kept_);
    kept_ = -1;
  }
  TemporaryFolder folder_;
  std::FILE* stream_;
  int kept_ = -1;
};

// Text that `print` prints on standard output. `print` must not contain assertions.
template <class Print>
std::string printed_by(const Print& print) {
  Captured out(stdout);
  print();
  return out.text();
}

using bench::AddVerb;

// The verb that `add` adds, with its name first. An error is in `err` as the program prints it.
Finished verb_here(AddVerb add, std::vector<std::string> words);

// A temporary store of a test, and verbs run on it within the test's process.

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
