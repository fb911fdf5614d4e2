// A bench's store as `fleet push` reads it: its ended runs, what of each the fleet does not have yet, and the small
// file beside the store (NAME-fleet) that keeps what was pushed where, so that `fleet status` can tell the backlog
// while the server is away. The file is a note only: a push asks the server.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "db/fleet/rows.h"

namespace tactbench::db::fleet {

struct LocalRun {
  std::int64_t run = 0;
  std::string uuid, content_sha256, started_utc;
  std::string
      fingerprint;  // of content and of all that is stored beside it; the same fits have another in another file
};

class LocalRuns {
 public:
  // Opens the store read-only, after RunStore::open_read_only has accepted it. Throws StoreError.
  explicit LocalRuns(const std::string& path);

  [[nodiscard]] std::vector<LocalRun> ended_runs();  // in the order of their numbers
  [[nodiscard]] std::int64_t frame_count(std::int64_t run);
  // Grows with each change that another connection makes.
  [[nodiscard]] std::int64_t version();
  [[nodiscard]] sqlite::Connection& connection() { return *connection_; }
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
  std::unique_ptr<sqlite::Connection> connection_;
};

// The note of what was pushed; a folder that cannot be written gives one that keeps nothing.
class PushedNote {
 public:
  PushedNote(const std::string& store_path, std::string fleet);

  void keep(const LocalRun& run, const std::string& utc);
  void keep_try(const std::string& utc, const std::string& error);  // error "": the server was there
  [[nodiscard]] std::map<std::string, std::string> fingerprints();  // by UUID
  struct Last {
    std::string pushed_utc, tried_utc, error;
  };
  [[nodiscard]] Last last();

 private:
  std::string fleet_;
  std::unique_ptr<sqlite::Connection> connection_;
};

// "202601" of "2026-01-31T12:00:00Z"; 0 when it is no such time.
std::int64_t month_of(const std::string& utc);

}  // namespace tactbench::db::fleet
