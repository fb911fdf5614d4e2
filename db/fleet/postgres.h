// A thin wrapper over libpq, the only place that includes libpq-fe.h: one connection and its statements. Every failure
// becomes a FleetError, every wait has a deadline, and answers of the server are validated: a wrong number of rows or
// columns, an answer that does not end, or one of an unexpected type is TB-FLEET-ANSWER.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace tactbench::db::fleet {

// The kind of failure; the exit code depends only on this.
enum class FleetCause {
  kLink,   // the server cannot be reached, refuses the login, or was lost: try again later
  kStore,  // the fleet cannot store or return the data: schema, disk, rights, or a difference in content
  kUsage,  // a named object does not exist, or the command is wrong; nothing was changed
};

// The error type of db/fleet/: a failure between a bench and the fleet's PostgreSQL, with an identifier TB-FLEET-*.
class FleetError : public std::runtime_error {
 public:
  FleetError(FleetCause cause, std::string id, const std::string& message, std::string remedy)
      : std::runtime_error(message), cause_(cause), id_(std::move(id)), remedy_(std::move(remedy)) {}
  [[nodiscard]] FleetCause cause() const { return cause_; }
  [[nodiscard]] const std::string& id() const { return id_; }
  [[nodiscard]] const std::string& remedy() const { return remedy_; }

 private:
  FleetCause cause_;
  std::string id_, remedy_;
};

using Row = std::vector<std::string>;  // the bytes of each column; NULL as ""

inline constexpr std::chrono::seconds kPatience(10);       // for connecting
inline constexpr std::chrono::seconds kSilence(60);        // a server that sends no byte for so long counts as lost
inline constexpr std::size_t kMaxAnswerBytes = 256 << 20;  // bytes of one statement's rows, unless more is expected

class Link {
 public:
  // `conninfo`: as for psql: "host=... dbname=...", "postgresql://...", "service=...". Other settings come from libpq's
  // environment and files (PGPASSWORD, ~/.pgpass, PGSSLROOTCERT); if none of them sets sslmode, a server on another
  // machine is connected only with TLS. Blocks for at most `patience`. `silence`: how long the server may send no byte
  // during a request; no statement may take longer than 60 times that. TB-FLEET-CONNECT, TB-FLEET-LOGIN, TB-FLEET-TLS,
  // TB-FLEET-CONNINFO, TB-FLEET-BUILD.
  explicit Link(const std::string& conninfo, std::chrono::seconds silence = kSilence,
                std::chrono::seconds patience = kPatience);
  ~Link();
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;

  // One statement. Values are transferred as bytes: each parameter is used as $n::text or $n::bytea, and each of the
  // `columns` is text or bytea. TB-FLEET-LOST, TB-FLEET-SILENT, TB-FLEET-ANSWER, TB-FLEET-FULL, TB-FLEET-DENIED,
  // TB-FLEET-OWNER, TB-FLEET-SQL.
  std::vector<Row> query(const std::string& sql, std::size_t columns, const std::vector<std::string>& parameters = {},
                         std::size_t max_bytes = kMaxAnswerBytes);
  // The same for a statement that returns one row.
  Row query_row(const std::string& sql, std::size_t columns, const std::vector<std::string>& parameters = {},
                std::size_t max_bytes = kMaxAnswerBytes);
  void execute(const std::string& script);  // several statements without parameters; their rows are dropped
  // The value of a numeric column. TB-FLEET-ANSWER.
  [[nodiscard]] std::int64_t number(const std::string& text) const;

  // "tactile on db.lab:5432", for messages; without user and password.
  [[nodiscard]] const std::string& where() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// `text` with *** for the passwords of connections in it: password=..., ://user:...@
std::string without_passwords(const std::string& text);

// BEGIN; rolls back unless committed.
class Transaction {
 public:
  explicit Transaction(Link& link, const char* manner = "");  // "READ ONLY"
  ~Transaction();
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;
  void commit();

 private:
  Link& link_;
  bool open_ = true;
};

}  // namespace tactbench::db::fleet
