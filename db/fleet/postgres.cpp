#include "db/fleet/postgres.h"

#include <dlfcn.h>
#include <fmt/format.h>
#include <libpq-fe.h>
#include <poll.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <new>
#include <regex>

namespace tactbench::db::fleet {
namespace {

using Time = std::chrono::steady_clock;

// libpq is loaded on first use: with the libraries that it needs (Kerberos, LDAP) the program would take half as long
// again to start.
// clang-format off
#define TACTBENCH_LIBPQ(X) \
  X(PQclear) X(PQconnectPoll) X(PQconnectStartParams) X(PQconnectionNeedsPassword) \
  X(PQconninfoFree) X(PQconninfoParse) X(PQconsumeInput) X(PQdb) X(PQerrorMessage) X(PQfinish) X(PQflush) X(PQfreemem) \
  X(PQgetResult) X(PQgetlength) X(PQgetvalue) X(PQhost) X(PQisBusy) X(PQnfields) X(PQntuples) X(PQport) X(PQresultErrorField) \
  X(PQresultStatus) X(PQsendQuery) X(PQsendQueryParams) X(PQsetErrorVerbosity) X(PQsetNoticeProcessor) \
  X(PQsetSingleRowMode) X(PQsetnonblocking) X(PQsocket) X(PQstatus) X(PQuser)
// clang-format on

struct Libpq {
  Libpq() {
    void* const library = dlopen("libpq.so.5", RTLD_NOW | RTLD_LOCAL);
    const auto find = [&](const char* name) {
      if (void* const found = library != nullptr ? dlsym(library, name) : nullptr) return found;
      throw FleetError(FleetCause::kUsage, "TB-FLEET-BUILD", fmt::format("libpq cannot be loaded: {}", dlerror()),
                       "install libpq5; everything except the fleet works without it");
    };
#define TACTBENCH_FIND(name) name = reinterpret_cast<decltype(name)>(find(#name));
    TACTBENCH_LIBPQ(TACTBENCH_FIND)
#undef TACTBENCH_FIND
  }
#define TACTBENCH_MEMBER(name) decltype(&::name) name = nullptr;  // NOLINT(bugprone-macro-parentheses)
  TACTBENCH_LIBPQ(TACTBENCH_MEMBER)
#undef TACTBENCH_MEMBER
};

const Libpq& libpq() {
  static const Libpq loaded;
  return loaded;
}

struct FreeResult {
  void operator()(PGresult* result) const { libpq().PQclear(result); }
};
using Result = std::unique_ptr<PGresult, FreeResult>;
// libpq's messages have several lines.
std::string trimmed(std::string text) {
  while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
  std::string line;
  for (const char c : text)
    if (c == '\n' || c == '\t')
      line += line.ends_with(' ') ? "" : " ";
    else
      line += c;
  return line;
}

// With SQLSTATE where the server gave one, since its words may be in any language.
[[noreturn]] void fail_connect(const std::string& where, const std::string& all, bool needs_password = false) {
  const std::string said = all.substr(0, all.find(" LOCATION: "));  // the first attempt, without the server's source
  // Skips quoted names: the name of a host or folder may contain SSL.
  const std::string unnamed = std::regex_replace(said, std::regex("\"[^\"]*\""), "\"\"");
  std::smatch found;
  const bool coded = std::regex_search(unnamed, found, std::regex(": +([0-9][0-9A-Z]{4}): "));
  if ((coded && found[1].str().starts_with("28")) || needs_password)
    throw FleetError(FleetCause::kLink, "TB-FLEET-LOGIN",
                     fmt::format("fleet {}: the login was refused: {}", where, said),
                     "check user and password (~/.pgpass, mode 0600, or PGPASSWORD) and the server's pg_hba.conf");
  if (unnamed.find("SSL") != std::string::npos || unnamed.find("certificate") != std::string::npos)
    throw FleetError(
        FleetCause::kLink, "TB-FLEET-TLS", fmt::format("fleet {}: no trusted connection: {}", where, said),
        "the certificate may be expired, of another name, or by an authority that sslrootcert does not name: "
        "openssl s_client -starttls postgres -connect HOST:PORT shows it and its dates. A server without TLS is "
        "reached only with sslmode=disable, and anyone who reads the traffic then has the password");
  throw FleetError(FleetCause::kLink, "TB-FLEET-CONNECT", fmt::format("fleet {}: cannot be reached: {}", where, said),
                   "check host, port and database, and that the server runs; the bench continues, and a later push "
                   "sends everything");
}

constexpr const char* kTlsMode = "PGSSLMODE";

// Anywhere but on this computer, as far as is known before names are looked up; libpq's own default would send a
// password in clear there.
bool goes_elsewhere(const PQconninfoOption* options) {
  const auto value = [&](const std::string& keyword) {
    const PQconninfoOption* own = options;
    while (own->keyword != keyword) ++own;
    const char* const named = own->envvar != nullptr ? std::getenv(own->envvar) : nullptr;
    return std::string(own->val != nullptr ? own->val : named != nullptr ? named : "");
  };
  const std::string host = value("hostaddr").empty() ? value("host") : value("hostaddr");
  const bool several = host.find(',') != std::string::npos;
  if (host.empty()) return !value("service").empty();  // a socket, unless a service names a host
  return several || (host[0] != '/' && host[0] != '@' && host != "localhost" && host != "127.0.0.1" && host != "::1");
}

constexpr std::size_t kMostNotices = 1 << 20;  // bytes in one statement

}  // namespace

struct Link::State {
  PGconn* handle = nullptr;
  std::string where;
  std::chrono::seconds silence = kSilence;
  std::size_t notices = 0;  // bytes
  Time::time_point end;     // of the statement under way

  ~State() {
    if (handle != nullptr) libpq().PQfinish(handle);  // where libpq cannot be loaded there is none
  }

  [[noreturn]] void fail_answer(const std::string& what) const {
    throw FleetError(FleetCause::kLink, "TB-FLEET-ANSWER",
                     fmt::format("fleet {}: the server does not answer as PostgreSQL does: {}", where, what),
                     "check that host and port are those of the fleet's PostgreSQL; the answer was discarded");
  }
  [[noreturn]] void fail_link(const std::string& said) const {
    throw FleetError(FleetCause::kLink, "TB-FLEET-LOST", fmt::format("fleet {}: the server was lost: {}", where, said),
                     "push again when the connection is back; no run was stored in part");
  }
  [[noreturn]] void fail_link() const { fail_link(trimmed(libpq().PQerrorMessage(handle))); }
  [[noreturn]] void fail(const PGresult* result) const;

  // Until the socket can be read, or also written.
  void wait(bool also_write) const {
    if (notices > kMostNotices || Time::now() > end) fail_answer("it does not come to an end");
    const auto deadline = std::min(Time::now() + silence, end);
    for (;;) {
      pollfd socket{libpq().PQsocket(handle), static_cast<short>(POLLIN | (also_write ? POLLOUT : 0)), 0};
      const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Time::now()).count();
      const int ready = ::poll(&socket, 1, std::max(static_cast<int>(left), 0));
      if (ready > 0) return;
      if (ready < 0 && errno == EINTR) continue;
      throw FleetError(FleetCause::kLink, "TB-FLEET-SILENT",
                       fmt::format("fleet {}: the server has been silent for {} s", where, silence.count()),
                       "check whether the server is overloaded or the network is down, then repeat the command: what "
                       "was pushed is kept");
    }
  }
  void begin() {
    notices = 0;
    end = Time::now() + 60 * silence;
  }
  // Of the statement under way; none: it is over.
  [[nodiscard]] Result next() const {
    const auto take_input = [&] {
      if (libpq().PQconsumeInput(handle) == 0) fail_link();
    };
    while (const int left = libpq().PQflush(handle)) {
      if (left < 0) fail_link();
      wait(true);
      take_input();
    }
    while (libpq().PQisBusy(handle) != 0) {
      wait(false);
      take_input();
    }
    return Result(libpq().PQgetResult(handle));
  }
  // All results; an error of any is thrown after all were read. `columns`: none, rows are dropped.
  std::vector<Row> collect(const std::size_t* columns, std::size_t max_bytes) const {
    std::vector<Row> rows;
    std::size_t bytes = 0;
    bool answered = false;
    Result failed;
    while (Result result = next()) {
      const ExecStatusType status = libpq().PQresultStatus(result.get());
      answered = true;
      if (status == PGRES_FATAL_ERROR) {
        if (!failed) failed = std::move(result);
        continue;
      }
      if (status != PGRES_COMMAND_OK && status != PGRES_TUPLES_OK && status != PGRES_SINGLE_TUPLE &&
          status != PGRES_EMPTY_QUERY)
        fail_answer("it begins a copy");
      for (int i = 0; i < libpq().PQntuples(result.get()) && columns != nullptr; ++i) {
        if (libpq().PQnfields(result.get()) != static_cast<int>(*columns))
          fail_answer(fmt::format("{} columns instead of {}", libpq().PQnfields(result.get()), *columns));
        Row& row = rows.emplace_back();
        for (int j = 0; j < static_cast<int>(*columns); ++j) {
          row.emplace_back(libpq().PQgetvalue(result.get(), i, j),
                           static_cast<std::size_t>(libpq().PQgetlength(result.get(), i, j)));
          bytes += row.back().size() + sizeof(std::string);
        }
        if (bytes > max_bytes) fail_answer(fmt::format("more than {} MB", max_bytes >> 20U));
      }
    }
    if (failed) fail(failed.get());
    if (!answered) fail(nullptr);
    return rows;
  }
};

void Link::State::fail(const PGresult* result) const {
  const char* code = result != nullptr ? libpq().PQresultErrorField(result, PG_DIAG_SQLSTATE) : nullptr;
  const std::string state = code != nullptr ? code : "";
  const char* primary = result != nullptr ? libpq().PQresultErrorField(result, PG_DIAG_MESSAGE_PRIMARY) : nullptr;
  const std::string said = primary != nullptr ? primary : trimmed(libpq().PQerrorMessage(handle));
  if (state.empty() || state.starts_with("08") || state.starts_with("57P") ||
      libpq().PQstatus(handle) == CONNECTION_BAD)
    fail_link(said);
  if (state == "53100")
    throw FleetError(FleetCause::kStore, "TB-FLEET-FULL",
                     fmt::format("fleet {}: the server's disk is full: {}", where, said),
                     "free space there and push again; nothing was changed, and the store keeps everything");
  if (state == "42501")
    throw FleetError(FleetCause::kStore, "TB-FLEET-DENIED",
                     fmt::format("fleet {}: user {} may not do this: {}", where, libpq().PQuser(handle), said),
                     "benches log in as members of tactbench_bench, readers of tactbench_analyst; only a user who may "
                     "create schemas and roles can make the schema");
  if (state == "TB001")  // db/fleet/runs.cpp
    throw FleetError(
        FleetCause::kStore, "TB-FLEET-OWNER", fmt::format("fleet {}: {}", where, said),
        "only the role that pushed the run first may add to it; the database's owner can transfer it: UPDATE "
        "fleet.owners");
  throw FleetError(FleetCause::kStore, "TB-FLEET-SQL", fmt::format("fleet {}: refused ({}): {}", where, state, said),
                   "see the server's log; nothing was changed");
}

Link::Link(const std::string& conninfo, std::chrono::seconds silence, std::chrono::seconds patience)
    : state_(std::make_unique<State>()) {
  state_->silence = silence;
  char* wrong = nullptr;
  PQconninfoOption* const options = libpq().PQconninfoParse(conninfo.c_str(), &wrong);
  const std::string said = wrong != nullptr ? trimmed(wrong) : "";
  libpq().PQfreemem(wrong);
  if (options == nullptr)
    throw FleetError(FleetCause::kUsage, "TB-FLEET-CONNINFO",
                     fmt::format("this is not a connection string of a fleet: {}", without_passwords(said)),
                     "write it as for psql: \"host=db.lab dbname=tactile user=bench_a sslmode=verify-full\", or "
                     "\"service=NAME\"");
  const bool tls = goes_elsewhere(options) && std::getenv(kTlsMode) == nullptr;
  libpq().PQconninfoFree(options);
  // Before what is given, which takes precedence.
  constexpr std::array<const char*, 7> kNames{"fallback_application_name",
                                              "tcp_user_timeout",
                                              "keepalives_idle",
                                              "keepalives_interval",
                                              "client_encoding",
                                              "dbname",
                                              nullptr};
  const std::string unacknowledged_ms = std::to_string(1000 * silence.count());
  const std::array<const char*, 7> values{"tactbench", unacknowledged_ms.c_str(), "20",   "10",
                                          "UTF8",      conninfo.c_str(),          nullptr};
  if (tls) ::setenv(kTlsMode, "require", 1);  // counts less than the text and the file of services
  state_->handle = libpq().PQconnectStartParams(kNames.data(), values.data(), 1);
  if (tls) ::unsetenv(kTlsMode);
  if (state_->handle == nullptr) throw std::bad_alloc();
  PGconn* const handle = state_->handle;
  const auto known = [](const char* text) { return std::string(text != nullptr ? text : "?"); };
  state_->where = fmt::format("{} on {}:{}", known(libpq().PQdb(handle)), known(libpq().PQhost(handle)),
                              known(libpq().PQport(handle)));
  libpq().PQsetErrorVerbosity(handle, PQERRORS_VERBOSE);  // brings the SQLSTATE, which is the same in every language
  libpq().PQsetNoticeProcessor(
      handle, [](void* state, const char* notice) { static_cast<State*>(state)->notices += 64 + std::strlen(notice); },
      state_.get());
  const auto deadline = Time::now() + patience;
  for (PostgresPollingStatusType polled = PGRES_POLLING_WRITING; libpq().PQstatus(handle) != CONNECTION_BAD;) {
    pollfd socket{libpq().PQsocket(handle), static_cast<short>(polled == PGRES_POLLING_READING ? POLLIN : POLLOUT), 0};
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Time::now()).count();
    const int ready = left > 0 ? ::poll(&socket, 1, static_cast<int>(left)) : 0;
    if (ready < 0 && errno == EINTR) continue;
    if (ready == 0) fail_connect(state_->where, fmt::format("no answer within {} s", patience.count()));
    polled = libpq().PQconnectPoll(handle);
    if (polled == PGRES_POLLING_OK || polled == PGRES_POLLING_FAILED) break;
  }
  if (libpq().PQstatus(handle) != CONNECTION_OK)
    fail_connect(state_->where, trimmed(libpq().PQerrorMessage(handle)),
                 libpq().PQconnectionNeedsPassword(handle) == 1);
  libpq().PQsetErrorVerbosity(handle, PQERRORS_DEFAULT);
  libpq().PQsetnonblocking(handle, 1);
}

Link::~Link() = default;

std::vector<Row> Link::query(const std::string& sql, std::size_t columns, const std::vector<std::string>& parameters,
                             std::size_t max_bytes) {
  std::vector<const char*> values;
  std::vector<int> lengths;
  const std::vector<int> as_bytes(parameters.size(), 1);
  for (const std::string& parameter : parameters) {
    values.push_back(parameter.data());
    lengths.push_back(static_cast<int>(parameter.size()));
  }
  state_->begin();
  if (libpq().PQsendQueryParams(state_->handle, sql.c_str(), static_cast<int>(values.size()), nullptr, values.data(),
                                lengths.data(), as_bytes.data(), 1) != 1)
    state_->fail_link();
  libpq().PQsetSingleRowMode(state_->handle);  // so that an answer without an end is noticed before memory is
  return state_->collect(&columns, max_bytes);
}

Row Link::query_row(const std::string& sql, std::size_t columns, const std::vector<std::string>& parameters,
                    std::size_t max_bytes) {
  std::vector<Row> rows = query(sql, columns, parameters, max_bytes);
  if (rows.size() != 1) state_->fail_answer(fmt::format("{} rows instead of one", rows.size()));
  return std::move(rows.front());
}

void Link::execute(const std::string& script) {
  state_->begin();
  if (libpq().PQsendQuery(state_->handle, script.c_str()) != 1) state_->fail_link();
  (void)state_->collect(nullptr, kMaxAnswerBytes);
}

std::int64_t Link::number(const std::string& text) const {
  std::int64_t value = 0;
  const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (failed != std::errc() || end != text.data() + text.size()) state_->fail_answer("an invalid number");
  return value;
}

const std::string& Link::where() const { return state_->where; }

std::string without_passwords(const std::string& text) {
  const std::string display_text = std::regex_replace(
      text, std::regex(R"(((?:password|pwd)\s*=\s*)('([^'\\]|\\.)*'|(\\.|[^\s\\])+))", std::regex::icase), "$1***");
  return std::regex_replace(display_text, std::regex(R"((://[^\s:/@]*:)\S*@)"), "$1***@");
}

Transaction::Transaction(Link& link, const char* manner) : link_(link) {
  link_.execute(std::string("BEGIN ") + manner);
}
Transaction::~Transaction() {
  try {
    if (open_) link_.execute("ROLLBACK");
  } catch (const FleetError&) {  // with the link the server rolls back
  }
}
void Transaction::commit() {
  open_ = false;
  link_.execute("COMMIT");
}

}  // namespace tactbench::db::fleet
