// Lag and creep as a document has them: each number at its bounds and beyond.
#include "analysis/identify/stored/dynamics_json.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <tuple>
#include <vector>

#include "analysis/identify/sensor_model.h"
#include "tests/analysis/identify/refusals.h"

using namespace tactbench::analysis;

namespace {

SensorDynamics stored_dynamics() {
  SensorDynamics dynamics;
  dynamics.shared.creep_s = {2.0, 20.0, 200.0};
  dynamics.shared.creep_share = {0.03, 0.0, 0.01};
  dynamics.shared.creep_half = 7.0;
  dynamics.shared.lag_s = 1.5;
  dynamics.shared.lag_share = 0.05;
  dynamics.residual_shape = {1.0, 0.0, 2.0, 3.0};
  dynamics.rate = {5, "ab"};
  dynamics.creep = {6, "cd"};
  return dynamics;
}

// What is said of a document with another value of a member; empty where it is taken.
std::string refused_dynamics(const std::string& member, const nlohmann::ordered_json& value) {
  nlohmann::ordered_json json = dynamics_json(stored_dynamics());
  json[nlohmann::ordered_json::json_pointer("/" + member)] = value;
  return why_invalid([&] { return dynamics_from(json); });
}

bool taxel_taken(const std::string& member, double value) {
  ModelTaxel taxel;
  nlohmann::ordered_json json;
  add_taxel_dynamics(taxel, json);
  json[member] = value;
  return why_invalid([&] { read_taxel_dynamics(json, taxel); }).empty();
}

}  // namespace

TEST_CASE("a document's lag and creep are read as they were written") {
  const SensorDynamics back = dynamics_from(dynamics_json(stored_dynamics()));
  CHECK(back.shared.creep_s == stored_dynamics().shared.creep_s);
  CHECK(back.shared.creep_share == stored_dynamics().shared.creep_share);
  CHECK((back.shared.creep_half == 7.0 && back.shared.lag_s == 1.5 && back.shared.lag_share == 0.05));
  CHECK(back.residual_shape == stored_dynamics().residual_shape);
  CHECK((back.rate.run == 5 && back.rate.content_sha256 == "ab"));
  CHECK((back.creep.run == 6 && back.creep.content_sha256 == "cd"));
  ModelTaxel taxel, read;
  taxel.creep_scale = 1.25;
  taxel.lag_share = 0.5;
  taxel.residual_psi = 0.75;
  nlohmann::ordered_json json;
  add_taxel_dynamics(taxel, json);
  read_taxel_dynamics(json, read);
  CHECK((read.creep_scale == 1.25 && read.lag_share == 0.5 && read.residual_psi == 0.75));
}

TEST_CASE("a document's lag and creep are refused beyond their bounds, by name") {
  for (const char* const member : {"creep_half", "lag_s"}) {
    CHECK(refused_dynamics(member, 1e-9).empty());
    CHECK(refused_dynamics(member, 1e9).empty());
    CHECK_THAT(refused_dynamics(member, 0.9e-9), Catch::Contains(member));
    CHECK_THAT(refused_dynamics(member, 1.1e9), Catch::Contains(member));
  }
  CHECK(refused_dynamics("lag_share", 0.0).empty());
  CHECK(refused_dynamics("lag_share", 0.9).empty());
  CHECK(refused_dynamics("creep_share", {0.0, 0.0, 0.0}).empty());
  CHECK(refused_dynamics("residual_shape", {0.0, 1.0}).empty());
  struct Row {
    const char* member;
    nlohmann::ordered_json value;
  };
  for (const Row& row : std::vector<Row>{{"lag_share", -0.01},
                                         {"lag_share", 0.91},
                                         {"creep_share", {0.0, 0.0}},
                                         {"creep_share", {0.0, 0.0, 0.0, 0.0}},
                                         {"creep_share", {0.1, -0.01, 0.0}},
                                         {"creep_s", {1.0, 2.0}},
                                         {"creep_s", {1.0, 2.0, 3.0, 4.0}},
                                         {"creep_s", {1.0, 0.0, 3.0}},
                                         {"residual_shape", {1.0, -0.01}}}) {
    CAPTURE(row.member, row.value.dump());
    CHECK_THAT(refused_dynamics(row.member, row.value), Catch::Contains("\"" + std::string(row.member) + "\""));
  }
  CHECK(refused_dynamics("rate/run", -1e15).empty());
  for (const std::string run : {"rate", "creep"}) {
    CHECK(refused_dynamics(run + "/run", 1e15).empty());
    const auto named = Catch::Contains("\"" + run + "\"");
    CHECK_THAT(refused_dynamics(run + "/run", 1.1e15), named);
    CHECK_THAT(refused_dynamics(run + "/run", 1.5), named);
    CHECK_THAT(refused_dynamics(run + "/content_sha256", 7), named);
  }
  for (const auto& [member, low, high] : {std::tuple{"creep_scale", 0.0, 10.0}, {"lag_share", 0.0, 0.9}}) {
    CAPTURE(member);
    CHECK(taxel_taken(member, low));
    CHECK(taxel_taken(member, high));
    CHECK_FALSE(taxel_taken(member, low - 0.01));
    CHECK_FALSE(taxel_taken(member, high + 0.01));
  }
  CHECK(taxel_taken("residual_psi", 0.0));
  CHECK(taxel_taken("residual_psi", 1e9));
  CHECK_FALSE(taxel_taken("residual_psi", -0.01));
  CHECK_FALSE(taxel_taken("residual_psi", 1.1e9));
}
