// Runs of the fleet as a store: the same file format that a bench writes, so that all that reads a store reads the
// fleet. A run has the fleet's number in it. Also what a push compares with: the content as the server holds it.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "db/fleet/postgres.h"
#include "db/fleet/tables.h"

namespace tactbench::db::fleet {

enum class Frames { kWith, kWithout };

class CopyBack {
 public:
  // Makes a store at `path`, which must not exist; it is a copy, and not written durably.
  CopyBack(Link& link, const std::string& path);

  // The runs' content alone: what is measured, and nothing that is said of it.
  void add_content(const std::vector<std::int64_t>& runs, Frames frames);
  // Content, fits, and the newest revision of all else; each compared with its hash, TB-FLEET-CHANGED. Verdicts keep
  // their fit where its run is among `runs`. With frames TB-FLEET-CONFLICT when one
  // serial is registered with two types; a list is made of the first registration.
  void add_runs(const std::vector<std::int64_t>& runs, Frames frames);
  // The content hash of a run that was added with frames, computed by the code that verifies a bench's runs.
  [[nodiscard]] std::string content_hash(std::int64_t run) const;
  [[nodiscard]] std::uintmax_t bytes() const;
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  void copy(const Table& table, const std::string& from_where, const std::string& order);
  void add_sensors(const std::string& list, bool exactly);
  void add_run_rows(const std::string& list);
  void add_fits(const std::string& list);
  void add_remarks(const std::string& list);
  void add_baselines();

  Link& link_;
  std::string path_;
  std::unique_ptr<sqlite::Connection> store_;
};

}  // namespace tactbench::db::fleet
