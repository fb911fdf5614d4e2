// The store of a program that runs with the power_cut library preloaded, and what a power cut leaves of it.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <random>
#include <string>

#include "tests/support/paths.h"
#include "tests/support/process.h"

namespace tactbench::tests {

class SyncedStore {
 public:
  // `disk_lies`: it says that it has synced, and has not; to show that a cut is one.
  explicit SyncedStore(std::string db, bool disk_lies = false) : db_(std::move(db)), lies_(disk_lies) {}

  // Of the program that writes the store: "NAME=value ...".
  [[nodiscard]] std::string environment() const {
    return fmt::format("LD_PRELOAD='{}' TACTBENCH_POWER_CUT='{}'{}", power_cut_path(), images_.path(),
                       lies_ ? " TACTBENCH_DISK_LIES=1" : "");
  }

  // No program has the store open any more. What was synced stays, and of what was not each sector of 512 bytes with
  // probability `kept`, as a disk writes in an order of its own. Returns how many sectors were lost.
  int cut(double kept, std::mt19937& random) {
    int lost = 0;
    for (const char* end : {"", "-wal"}) {
      const std::string name = db_ + end;
      const std::string image = images_.path(std::filesystem::path(name).filename());
      if (!std::filesystem::exists(image)) continue;  // was not opened
      std::string survives = read_file(image);
      const std::string was = std::filesystem::exists(name) ? read_file(name) : std::string();
      for (std::size_t at = 0; at < was.size(); at += kSector) {
        const std::string sector = was.substr(at, kSector);
        if (at < survives.size() && survives.compare(at, sector.size(), sector) == 0) continue;
        if (std::bernoulli_distribution(kept)(random)) {
          survives.resize(std::max(survives.size(), at + sector.size()));
          survives.replace(at, sector.size(), sector);
        } else {
          ++lost;
        }
      }
      std::filesystem::remove(name);
      write_file(name, survives);
      std::filesystem::remove(image);
    }
    std::filesystem::remove(db_ + "-shm");  // shared memory: never on the disk
    return lost;
  }

 private:
  static constexpr std::size_t kSector = 512;

  const std::string db_;
  const bool lies_;
  TemporaryFolder images_;
};

}  // namespace tactbench::tests
