// The name of a fleet's server, and what a refusal at its door is called.
#include <dlfcn.h>

#include <catch2/catch.hpp>
#include <cstdlib>

#include "db/fleet/postgres.h"
#include "tests/db/fleet/scripted_postgres.h"

namespace tactbench::tests::postgres {

using namespace db::fleet;
using Catch::Contains;

namespace {

// libpq's environment as if nobody had set it, while this lives.
class BareEnvironment {
 public:
  BareEnvironment() {
    for (const char* name : {"PGHOST", "PGHOSTADDR", "PGPORT", "PGDATABASE", "PGUSER", "PGSERVICE", "PGPASSWORD"}) {
      const char* const value = std::getenv(name);
      if (value != nullptr) kept_.emplace_back(name, value);
      ::unsetenv(name);
    }
  }
  ~BareEnvironment() {
    for (const auto& [name, value] : kept_) ::setenv(name.c_str(), value.c_str(), 1);
  }
  BareEnvironment(const BareEnvironment&) = delete;
  BareEnvironment& operator=(const BareEnvironment&) = delete;

 private:
  std::vector<std::pair<std::string, std::string>> kept_;
};

// What is told when the server answers the start so.
Told refused(const Answer& answer) {
  const BareEnvironment bare;
  Server server({answer});
  return told([&] { const Link link(server.conninfo() + " passfile=/none"); });
}

}  // namespace

TEST_CASE("fleet server: its name is the database on host and port, and what is not said comes from libpq") {
  if (!built_with_libpq()) return;
  const BareEnvironment bare;
  CHECK(where_of("host=db.lab port=5433 dbname=tactile user=u password=p") == "tactile on db.lab:5433");
  CHECK(where_of("host=db.lab dbname=tactile") == "tactile on db.lab:5432");
  CHECK(where_of("hostaddr=10.0.0.7 dbname=tactile") == "tactile on 10.0.0.7:5432");
  CHECK(where_of("host=db.lab hostaddr=10.0.0.7 dbname=tactile") == "tactile on db.lab:5432");
  CHECK(where_of("host=db.lab user=bench_a") == "bench_a on db.lab:5432");
  CHECK(where_of("dbname=tactile") == "tactile on this machine:5432");
  CHECK(where_of("postgresql://u:p@db.lab:6000/tactile") == "tactile on db.lab:6000");
  CHECK(where_of("service=lab") == "service lab");
  CHECK(where_of("service=lab user=u dbname=tactile") == "service lab");
  CHECK(where_of("service=lab host=db.lab dbname=tactile") == "tactile on db.lab:5432");
  CHECK(where_of("service=lab hostaddr=10.0.0.7 dbname=tactile") == "tactile on 10.0.0.7:5432");
  ::setenv("PGHOST", "from.environment", 1);
  ::setenv("PGDATABASE", "elsewhere", 1);
  const std::string unsaid = where_of("port=7"), said = where_of("host=db.lab dbname=tactile");
  ::unsetenv("PGHOST");
  ::unsetenv("PGDATABASE");
  CHECK(unsaid == "elsewhere on from.environment:7");
  CHECK(said == "tactile on db.lab:5432");
}

TEST_CASE("fleet server: words that name no server are the caller's, in libpq's own words") {
  if (!built_with_libpq()) return;
  for (const auto& [words, why] : {std::pair("nonsense", "missing \"=\""), std::pair("colour=red", "colour")}) {
    const Told error = told([&] { (void)where_of(words); });
    CHECK(error.id == "TB-FLEET-CONNINFO");
    CHECK(error.cause == FleetCause::kUsage);
    CHECK_THAT(error.message, Contains("this names no fleet: ") && Contains(why) && !Contains("\n"));
    CHECK_THAT(error.remedy, Contains("host=db.lab"));
    CHECK(told([&] { const Link link(words); }).id == "TB-FLEET-CONNINFO");
  }
}

TEST_CASE("fleet server: libpq's version is written as PostgreSQL writes it") {
  CHECK(built_with_libpq() == !libpq_version().empty());
  if (!built_with_libpq()) return;
  void* const library = ::dlopen("libpq.so.5", RTLD_NOW | RTLD_LOCAL);
  REQUIRE(library != nullptr);
  const auto ask = reinterpret_cast<int (*)()>(::dlsym(library, "PQlibVersion"));
  REQUIRE(ask != nullptr);
  const std::string number = std::to_string(ask());  // 150018 is 15.18
  REQUIRE(number.size() == 6);
  CHECK(libpq_version() == number.substr(0, 2) + "." + std::to_string(std::stoi(number.substr(2))));
}

TEST_CASE("fleet server: a refusal at the door is told by its code, and without one by what is said of certificates") {
  if (!built_with_libpq()) return;
  struct Refusal {
    const char* code;
    const char* said;
    const char* id;
  };
  for (const Refusal& refusal :
       std::vector<Refusal>{{"28P01", "password authentication failed", "TB-FLEET-LOGIN"},
                            {"28000", "no entry in pg_hba.conf, no SSL", "TB-FLEET-LOGIN"},
                            {"3D000", "database \"tactile\" does not exist", "TB-FLEET-CONNECT"},
                            {"53300", "too many clients already", "TB-FLEET-CONNECT"},
                            {"08P01", "SSL is needed here", "TB-FLEET-TLS"},
                            {"08006", "the certificate has expired", "TB-FLEET-TLS"},
                            {"57P03", "the database system is starting up", "TB-FLEET-CONNECT"}}) {
    CAPTURE(refusal.code);
    const Told error = refused(postgres::error(refusal.code, refusal.said));
    CHECK(error.id == refusal.id);
    CHECK(error.cause == FleetCause::kLink);
    CHECK_THAT(error.message, Contains("tactile on ") && Contains(refusal.said) && !Contains("LOCATION"));
    CHECK_FALSE(error.remedy.empty());
  }
  const Told asked = refused(message('R', number(3, 4)));  // for a password, and there is none
  CHECK(asked.id == "TB-FLEET-LOGIN");
  CHECK_THAT(asked.message, Contains("the login was refused: "));
  CHECK_THAT(asked.remedy, Contains(".pgpass"));
  CHECK(refused(kHangsUp).id == "TB-FLEET-CONNECT");
  const TemporaryFolder empty;
  const Told nobody = told([&] { const Link link("host=" + empty.path() + " dbname=tactile user=u"); });
  CHECK(nobody.id == "TB-FLEET-CONNECT");
  CHECK_THAT(nobody.message, Contains("cannot be reached: "));
  const Told named = told([&] { const Link link("host=" + empty.path() + "/SSL-certificate dbname=SSL user=u"); });
  CHECK(named.id == "TB-FLEET-CONNECT");
  CHECK_THAT(named.message, Contains("/SSL-certificate/"));
}

TEST_CASE("fleet server: one that says nothing is given up when the patience with it is over") {
  if (!built_with_libpq()) return;
  const BareEnvironment bare;
  for (const bool says_a_part : {false, true}) {
    // The part asks for a password, but for its last byte.
    const std::string asks = message('R', number(3, 4));
    Server server({Answer(says_a_part ? asks.substr(0, asks.size() - 1) : "")});
    const auto begun = std::chrono::steady_clock::now();
    const Told error = told([&] { const Link link(server.conninfo(), kSilence, kSoon); });
    CHECK(error.id == "TB-FLEET-CONNECT");
    CHECK(error.cause == FleetCause::kLink);
    CHECK(error.message == "fleet " + server.where() + ": cannot be reached: no answer within 1 s");
    CHECK_THAT(error.remedy, Contains("check host, port and database"));
    CHECK(std::chrono::steady_clock::now() - begun >= std::chrono::milliseconds(990));
  }
  CHECK(kPatience == std::chrono::seconds(10));
  CHECK(kSilence == std::chrono::seconds(60));
}

}  // namespace tactbench::tests::postgres
