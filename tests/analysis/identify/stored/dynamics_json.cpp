// Lag and creep as a document has them: each number at its bounds and beyond.
#include "analysis/identify/stored/dynamics_json.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <tuple>

#include "analysis/identify/sensor_model.h"

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
  try {
    (void)dynamics_from(json);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return {};
}

bool taxel_taken(const std::string& member, double value) {
  ModelTaxel taxel;
  nlohmann::ordered_json json;
  add_taxel_dynamics(taxel, json);
  json[member] = value;
  try {
    read_taxel_dynamics(json, taxel);
  } catch (const std::invalid_argument&) {
    return false;
  }
  return true;
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
  CHECK_THAT(refused_dynamics("lag_share", -0.01), Catch::Contains("lag_share"));
  CHECK_THAT(refused_dynamics("lag_share", 0.91), Catch::Contains("\"lag_share\""));
  CHECK(refused_dynamics("creep_share", {0.0, 0.0, 0.0}).empty());
  CHECK_THAT(refused_dynamics("creep_share", {0.0, 0.0}), Catch::Contains("creep_share"));
  CHECK_THAT(refused_dynamics("creep_share", {0.0, 0.0, 0.0, 0.0}), Catch::Contains("creep_share"));
  const std::string no_three = " is not a list of three numbers from 0 on";
  CHECK(refused_dynamics("creep_share", {0.1, -0.01, 0.0}) == "\"creep_share\"" + no_three);
  CHECK(refused_dynamics("creep_s", {1.0, 2.0}) == "\"creep_s\"" + no_three);
  CHECK(refused_dynamics("creep_s", {1.0, 2.0, 3.0, 4.0}) == "\"creep_s\"" + no_three);
  CHECK(refused_dynamics("creep_s", {1.0, 0.0, 3.0}) == "a \"creep_s\" is 0");
  CHECK(refused_dynamics("residual_shape", {0.0, 1.0}).empty());
  CHECK_THAT(refused_dynamics("residual_shape", {1.0, -0.01}), Catch::Contains("\"residual_shape\""));
  CHECK(refused_dynamics("rate/run", 1e15).empty());
  CHECK(refused_dynamics("rate/run", -1e15).empty());
  for (const std::string run : {"rate", "creep"}) {
    CHECK(refused_dynamics(run + "/run", 1e15).empty());
    CHECK(refused_dynamics(run + "/run", 1.1e15) == "\"" + run + "\" names no run");
    CHECK(refused_dynamics(run + "/run", 1.5) == "\"" + run + "\" names no run");
    CHECK(refused_dynamics(run + "/content_sha256", 7) == "\"" + run + "\" names no run");
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
