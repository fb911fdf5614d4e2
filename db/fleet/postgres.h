// A thin wrapper over libpq, the only place with libpq-fe.h: one connection, queries, binary COPY both ways. Every
// failure becomes a FleetError; every wait has a deadline. Without libpq the program is built all the same, and Link's
// constructor throws TB-FLEET-BUILD.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "db/fleet/fleet_error.h"

namespace tactbench::db::fleet {

using TextRow = std::vector<std::string>;  // NULL as ""

inline constexpr std::chrono::seconds kPatience(10);  // for connecting
inline constexpr std::chrono::seconds kSilence(60);   // without a byte the server counts as lost

class Link {
 public:
  // `conninfo`: as psql takes it, "host=... dbname=...", "postgresql://...", "service=...". What it does not say comes
  // from libpq's own environment and files (PGPASSWORD, ~/.pgpass, PGSSLROOTCERT). Blocks for `patience` at most.
  // `silence`: how long the server may send no byte while something is asked. TB-FLEET-CONNECT, TB-FLEET-LOGIN,
  // TB-FLEET-TLS, TB-FLEET-CONNINFO.
  explicit Link(const std::string& conninfo, std::chrono::seconds silence = kSilence,
                std::chrono::seconds patience = kPatience);
  ~Link();
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;

  // One statement; `parameters` are $1, $2 ... as text. TB-FLEET-LOST, TB-FLEET-FULL, TB-FLEET-DENIED, TB-FLEET-TEXT,
  // TB-FLEET-SQL, TB-FLEET-SILENT.
  std::vector<TextRow> query(const std::string& sql, const std::vector<std::string>& parameters = {});
  void execute(const std::string& script);  // several statements without parameters
  // COPY ... FROM STDIN: `more` fills a buffer, and returns false when there is nothing more.
  void copy_in(const std::string& sql, const std::function<bool(std::string&)>& more);
  // COPY ... TO STDOUT: `take` sees each piece, of whole rows.
  void copy_out(const std::string& sql, const std::function<void(std::string_view)>& take);

  // "tactile on db.lab:5432", for messages, and the name under which a bench keeps what it pushed there. Holds neither
  // user nor password.
  [[nodiscard]] const std::string& where() const;
  [[nodiscard]] const std::string& user() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// where() of a server that need not be there. TB-FLEET-CONNINFO.
std::string where_of(const std::string& conninfo);
bool built_with_libpq();
std::string libpq_version();  // "15.18"; empty: built without

// BEGIN; rolls back unless committed.
class Transaction {
 public:
  explicit Transaction(Link& link, const char* manner = "");  // "ISOLATION LEVEL REPEATABLE READ READ ONLY"
  ~Transaction();
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;
  void commit();

 private:
  Link& link_;
  bool open_ = true;
};

}  // namespace tactbench::db::fleet
