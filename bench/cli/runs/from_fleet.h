// Makes runs of the fleet available to a verb that reads a store: copies them into a temporary store, which the verb
// then reads.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bench/cli/session.h"
#include "bench/common/private_files.h"
#include "db/fleet/runs.h"
#include "db/run_store.h"

namespace tactbench::bench {

// --from on a verb that reads runs.
void add_from(CLI::App& verb, std::string& from);

// "12". Throws Error TB-USAGE.
std::int64_t run_number(const std::string& text);

class FromFleet {
 public:
  // `given`: how to connect; for "fleet" and "" as TACTBENCH_FLEET or tactbench.toml says, Error TB-USAGE when neither
  // does. Throws FleetError: TB-FLEET-CONNECT, TB-FLEET-LOGIN, TB-FLEET-TLS, TB-FLEET-EMPTY, TB-FLEET-SCHEMA.
  FromFleet(Session& session, const std::string& given);
  ~FromFleet();
  FromFleet(const FromFleet&) = delete;
  FromFleet& operator=(const FromFleet&) = delete;

  [[nodiscard]] db::fleet::Link& link() { return link_; }
  // From here to the end of this object session.db is a new temporary store with these runs, under the fleet's numbers,
  // each as it was pushed: compared with its hashes by the code that verifies a bench's own runs. TB-FLEET-CHANGED;
  // TB-FLEET-CONFLICT when one serial is registered with two types. `also`: these where they can be read; the others
  // are named on standard error and left out.
  void take(const std::vector<db::fleet::FleetRun>& runs, const std::vector<db::fleet::FleetRun>& also = {});

 private:
  void take_one(db::RunStore& store, const db::fleet::FleetRun& run);
  Session& session_;
  db::fleet::Link link_;
  ScratchFolder folder_;
  std::string db_before_;
};

}  // namespace tactbench::bench
