// The laboratory file: all fields, defaults, refusals.
#include <catch2/catch.hpp>

#include "bench/config/config.h"
#include "bench/config/config_laboratory.h"

using namespace tactbench;
using namespace tactbench::bench;

TEST_CASE("the shipped laboratory file reads, and every field of it is empty") {
  const analysis::Laboratory lab = read_laboratory(find_config("lab.toml"));
  CHECK(lab.sha256.size() == 64);
  for (const std::string* field : {&lab.laboratory, &lab.address, &lab.place, &lab.accreditation, &lab.customer,
                                   &lab.customer_address, &lab.order, &lab.received, &lab.condition, &lab.cable,
                                   &lab.mounting, &lab.medium, &lab.environment, &lab.deviations, &lab.remarks})
    CHECK(field->empty());
  CHECK(lab.instruments.empty());
}

TEST_CASE("a laboratory file's fields and certificates are read") {
  const analysis::Laboratory lab = parse_laboratory(
      "schema = 1\nlaboratory = \"L\"\nmedium = \"dry air\"\nreceived = \"2026-02-28\"\n[[instrument]]\nserial = "
      "\"P-1\"\ncertificate = "
      "\"C-1\"\ndue = \"2027-01-31\"\n",
      "lab.toml");
  CHECK(lab.laboratory == "L");
  CHECK(lab.medium == "dry air");
  CHECK(lab.received == "2026-02-28");
  REQUIRE(lab.instruments.size() == 1);
  CHECK(lab.instruments[0].certificate == "C-1");
  CHECK(lab.instruments[0].due == "2027-01-31");
}

TEST_CASE("unknown keys, wrong types and no dates are refused with their place") {
  const auto id_of = [](const std::string& text) -> std::string {
    try {
      (void)parse_laboratory(text, "lab.toml");
    } catch (const sequences::FileError& error) {
      CHECK_THAT(error.where(), Catch::Contains("lab.toml"));
      return error.id();
    }
    return "accepted";
  };
  CHECK(id_of("schema = 1\nlaboratry = \"L\"\n") == "TB-FILE-KEY");
  CHECK(id_of("schema = 1\n[[instrument]]\nserial = \"1\"\ndueto = \"2027-01-31\"\n") == "TB-FILE-KEY");
  CHECK(id_of("schema = 1\nlaboratory = 5\n") == "TB-FILE-VALUE");
  CHECK(id_of("schema = 1\nreceived = \"31.01.2026\"\n") == "TB-FILE-VALUE");
  CHECK(id_of("schema = 1\nreceived = \"2026-13-01\"\n") == "TB-FILE-VALUE");
  CHECK(id_of("schema = 1\n[[instrument]]\nserial = \"\"\n") == "TB-FILE-VALUE");
  CHECK(id_of("schema = 2\n") == "TB-FILE-VALUE");
  CHECK(id_of("schema = 1\n") == "accepted");
}
