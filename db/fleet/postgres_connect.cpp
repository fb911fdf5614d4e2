// Connecting, and what the server's refusals mean.
#ifdef TACTBENCH_HAVE_LIBPQ

#include <dlfcn.h>
#include <fmt/format.h>
#include <poll.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <new>
#include <regex>

#include "db/fleet/postgres_state.h"

namespace tactbench::db::fleet {

Libpq::Libpq() {
  void* const library = dlopen("libpq.so.5", RTLD_NOW | RTLD_LOCAL);
  const auto find = [&](const char* name) -> void* {
    void* const found = library != nullptr ? dlsym(library, name) : nullptr;
    if (found != nullptr) return found;
    throw FleetError(FleetCause::kUsage, "TB-FLEET-BUILD", fmt::format("libpq cannot be loaded: {}", dlerror()),
                     "install libpq5; all but the fleet works without it");
  };
#define TACTBENCH_FIND(name) name = reinterpret_cast<decltype(name)>(find(#name));
  TACTBENCH_LIBPQ(TACTBENCH_FIND)
#undef TACTBENCH_FIND
}

const Libpq& libpq() {
  static const Libpq loaded;
  return loaded;
}

void Link::State::fail(const PGresult* result) const {
  const char* code = result != nullptr ? libpq().PQresultErrorField(result, PG_DIAG_SQLSTATE) : nullptr;
  const std::string state = code != nullptr ? code : "";
  const char* primary = result != nullptr ? libpq().PQresultErrorField(result, PG_DIAG_MESSAGE_PRIMARY) : nullptr;
  const std::string said = primary != nullptr ? primary : trimmed(libpq().PQerrorMessage(handle));
  if (state.empty() || state.starts_with("08") || state.starts_with("57P") ||
      libpq().PQstatus(handle) == CONNECTION_BAD) {
    throw FleetError(FleetCause::kLink, "TB-FLEET-LOST", fmt::format("fleet {}: the server was lost: {}", where, said),
                     "push again when it is back: a run is there whole or not at all");
  }
  if (state == "53100") {
    throw FleetError(FleetCause::kStore, "TB-FLEET-FULL",
                     fmt::format("fleet {}: the server's disk is full: {}", where, said),
                     "free space there and push again; nothing was changed, and the store keeps everything");
  }
  if (state == "42501") {
    throw FleetError(FleetCause::kStore, "TB-FLEET-DENIED",
                     fmt::format("fleet {}: user {} may not do this: {}", where, user, said),
                     "benches log in as members of tactbench_bench, readers of tactbench_analyst; who makes the schema "
                     "may create schemas and roles");
  }
  if (state == "22021" || state == "22P05") fail_text(said);
  throw FleetError(FleetCause::kStore, "TB-FLEET-SQL", fmt::format("fleet {}: refused ({}): {}", where, state, said),
                   "see the server's log; nothing was changed");
}

namespace {

[[noreturn]] void fail_connect(const std::string& where, const std::string& all, bool needs_password = false) {
  const std::string said = all.substr(0, all.find(" LOCATION: "));  // the first attempt, without the server's source
  // Names stand in quotes: a host or a folder may have SSL in its own.
  const std::string unnamed = std::regex_replace(said, std::regex("\"[^\"]*\""), "\"\"");
  std::smatch found;
  const bool coded = std::regex_search(unnamed, found, std::regex(": +([0-9][0-9A-Z]{4}): "));
  const std::string state = coded ? found[1].str() : "";
  if (state.starts_with("28") || needs_password)
    throw FleetError(FleetCause::kLink, "TB-FLEET-LOGIN",
                     fmt::format("fleet {}: the login was refused: {}", where, said),
                     "check user and password (~/.pgpass, mode 0600, or PGPASSWORD) and the server's pg_hba.conf");
  if (unnamed.find("SSL") != std::string::npos || unnamed.find("certificate") != std::string::npos)
    throw FleetError(
        FleetCause::kLink, "TB-FLEET-TLS", fmt::format("fleet {}: no trusted connection: {}", where, said),
        "the certificate may be expired, of another name, or by an authority that sslrootcert does not name: "
        "openssl s_client -starttls postgres -connect HOST:PORT shows it and its dates");
  throw FleetError(
      FleetCause::kLink, "TB-FLEET-CONNECT", fmt::format("fleet {}: cannot be reached: {}", where, said),
      "check host, port and database, and that the server runs; the bench goes on, and a later push brings "
      "everything");
}

std::string where_of_options(PQconninfoOption* options) {
  std::string host, address, port, name, user, service;
  for (const PQconninfoOption* option = options; option->keyword != nullptr; ++option) {
    const std::string keyword = option->keyword, value = option->val != nullptr ? option->val : "";
    if (keyword == "host") host = value;
    if (keyword == "hostaddr") address = value;
    if (keyword == "port") port = value;
    if (keyword == "dbname") name = value;
    if (keyword == "user") user = value;
    if (keyword == "service") service = value;
  }
  if (host.empty()) host = address;
  if (name.empty()) name = user;
  if (!service.empty() && host.empty()) return fmt::format("service {}", service);
  return fmt::format("{} on {}:{}", name.empty() ? "the user's database" : name, host.empty() ? "this machine" : host,
                     port.empty() ? "5432" : port);
}

struct FreeOptions {
  void operator()(PQconninfoOption* options) const { libpq().PQconninfoFree(options); }
};

}  // namespace

std::string where_of(const std::string& conninfo) {
  char* error = nullptr;
  const std::unique_ptr<PQconninfoOption, FreeOptions> given(libpq().PQconninfoParse(conninfo.c_str(), &error));
  const std::string said = error != nullptr ? trimmed(error) : "";
  libpq().PQfreemem(error);
  if (!given) {
    throw FleetError(FleetCause::kUsage, "TB-FLEET-CONNINFO", fmt::format("this names no fleet: {}", said),
                     "write it as psql takes it: \"host=db.lab dbname=tactile user=bench_a\", or \"service=NAME\"");
  }
  const std::unique_ptr<PQconninfoOption, FreeOptions> defaults(libpq().PQconndefaults());
  for (PQconninfoOption *own = given.get(), *other = defaults.get(); other != nullptr && own->keyword != nullptr;
       ++own, ++other) {
    if (own->val == nullptr && other->val != nullptr) own->val = strdup(other->val);  // freed with the options
  }
  return where_of_options(given.get());
}

bool built_with_libpq() { return true; }
std::string libpq_version() {
  return fmt::format("{}.{}", libpq().PQlibVersion() / 10000, libpq().PQlibVersion() % 10000);
}

Link::Link(const std::string& conninfo, std::chrono::seconds silence, std::chrono::seconds patience)
    : state_(std::make_unique<State>()) {
  state_->silence = silence;
  state_->where = where_of(conninfo);
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
  state_->handle = libpq().PQconnectStartParams(kNames.data(), values.data(), 1);
  if (state_->handle == nullptr) throw std::bad_alloc();
  PGconn* const handle = state_->handle;
  libpq().PQsetErrorVerbosity(handle, PQERRORS_VERBOSE);  // brings the SQLSTATE, which is the same in every language
  libpq().PQsetNoticeProcessor(
      handle, [](void*, const char*) {}, nullptr);
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
  state_->user = libpq().PQuser(handle);
}

Link::~Link() = default;

const std::string& Link::where() const { return state_->where; }
const std::string& Link::user() const { return state_->user; }

}  // namespace tactbench::db::fleet

#endif
