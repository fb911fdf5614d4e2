// Runs of the fleet for a verb that reads a store: they are copied into a temporary store, and the verb reads that.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "bench/cli/session.h"
#include "bench/common/private_files.h"
#include "db/fleet/copy_back.h"

namespace tactbench::bench {

// --from on a verb that reads runs.
void add_from(CLI::App& verb, std::string& from);

// The connection that was named: what `given` says, or for "fleet" and "" what TACTBENCH_FLEET or tactbench.toml says.
// Throws Error TB-USAGE when nothing names one.
std::string fleet_named(const std::string& given, Session& session);

// "12". Throws Error TB-USAGE.
std::int64_t run_number(const std::string& text);

class FromFleet {
 public:
  // Throws FleetError: TB-FLEET-CONNECT, TB-FLEET-LOGIN, TB-FLEET-TLS, TB-FLEET-EMPTY, TB-FLEET-OLDER, TB-FLEET-NEWER.
  FromFleet(Session& session, const std::string& given);
  ~FromFleet();
  FromFleet(const FromFleet&) = delete;
  FromFleet& operator=(const FromFleet&) = delete;

  [[nodiscard]] db::fleet::Link& link() { return link_; }
  [[nodiscard]] const std::string& where() const { return link_.where(); }
  std::int64_t run_named(const std::string& name);
  std::vector<std::int64_t> with_what_they_rest_on(const std::vector<std::int64_t>& runs);
  // From here to the end of this object session.db is a new temporary store with these runs.
  void take(const std::vector<std::int64_t>& runs, db::fleet::Frames frames);

 private:
  Session& session_;
  db::fleet::Link link_;
  ScratchFolder folder_;
  std::string db_before_;
  int stores_ = 0;
};

}  // namespace tactbench::bench
