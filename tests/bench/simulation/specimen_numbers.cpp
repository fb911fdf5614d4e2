// The simulated film in numbers: what another implementation of its equations (bench/simulation/README.md) gives for
// the same seeds, in Python, to twelve digits. A deliberate change of the film changes them.
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "bench/simulation/specimen.h"
#include "bench/simulation/specimen_film.h"

using namespace tactbench::bench;

namespace {

Approx close_to(double value) { return Approx(value).epsilon(0.0).margin(2e-11 * std::max(1.0, std::abs(value))); }

void check_all(const std::vector<double>& made, const std::vector<double>& expected) {
  REQUIRE(made.size() >= expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    INFO("value " << i);
    CHECK(made[i] == close_to(expected[i]));
  }
}

// Everything at once on 3 x 4 taxels.
SpecimenOptions all_effects() {
  SpecimenOptions options;
  options.sensor_seed = 9;
  options.mount_seed = 4;
  options.mount_turn = MountTurn::kRowsMirrored;
  options.turned_in_chamber_deg = 20.0;
  options.edge_outside = MountEdge::kLastColumn;
  options.edge_outside_lines = 2;
  options.temperature_c = 31.0;
  options.age_months = 5.0;
  options.rows = 3;
  options.columns = 4;
  options.effects.row_crosstalk = 0.03;
  options.effects.column_crosstalk = 0.02;
  options.effects.temperature_coefficient = -0.004;
  options.effects.lift_off_psi = 0.5;
  options.effects.chamber_nonuniformity = 0.1;
  options.effects.chamber_tilt = 0.05;
  options.effects.chamber_tilt_deg = 70.0;
  options.effects.zero_drift_v_per_month = 0.003;
  options.effects.gain_drift_per_month = 0.02;
  options.effects.gain_drift_per_thousand_cycles = 0.4;
  options.effects.remount_variation = 0.06;
  using Kind = TaxelDefect::Kind;
  options.defects = {{Kind::kDead, 0, 1, 0, 0},
                     {Kind::kStuck, 2, 0, 0, 0},
                     {Kind::kSaturated, 1, 3, 0, 0},
                     {Kind::kSwapped, 0, 0, 1, 2}};
  return options;
}

}  // namespace

TEST_CASE("specimen numbers: every effect and defect at once, and the film's memory behind it") {
  Specimen specimen(all_effects());
  specimen.advance(20.0, 1.0);
  specimen.advance(60.0, 2.0);
  std::vector<double> contact(12);
  for (std::size_t i = 0; i < 12; ++i) contact[i] = 0.5 * static_cast<double>(i);
  std::vector<double> ahead(12);
  specimen.output_after(15.0, 0.4, ahead, contact);
  specimen.advance(15.0, 0.4, contact);
  std::vector<double> volts(12);
  specimen.output(volts);
  CHECK(ahead == volts);
  check_all(volts, {0.797345187845, 2.838411623332, 2.873454999351, 0.634471640397, 3.127802774521, 3.410191251043,
                    2.178494576059, 5.0, 3.477816767228, 0.0, 1.426830868039, 0.965529148249});
  const auto state = nlohmann::json::parse(specimen.state());
  CHECK(state["virgin"].get<double>() == close_to(std::exp(-2.0)));
  CHECK(state["lag_psi"].get<double>() == close_to(40.65416821350741));
  CHECK(state["travel_psi"] == 60.0);
  const auto plays = state["plays"].get<std::vector<std::vector<double>>>();
  const auto creep = state["creep"].get<std::vector<std::vector<double>>>();
  const std::vector<double> of_3 = {3.035397305843, 4.506115183715, 5.976833061586,
                                    7.259926458874, 7.259926458874, 7.259926458874};
  const std::vector<double> of_6 = {19.758818219957, 25.540096935516, 31.321375651075,
                                    37.928551325999, 46.187520919655, 55.946948811894};
  REQUIRE(plays.size() == 6);
  for (std::size_t k = 0; k < 6; ++k) {
    CHECK(plays[k][3] == close_to(of_3[k]));
    CHECK(plays[k][6] == close_to(of_6[k]));
  }
  const std::vector<double> crept = {0.428340410927, 0.25827771038, 0.044311530934, 0.005776991814};
  REQUIRE(creep.size() == 4);
  for (std::size_t j = 0; j < 4; ++j) CHECK(creep[j][3] == close_to(crept[j]));
}

TEST_CASE("specimen numbers: what the make of an array is, and its shares of the chamber's pressure") {
  const FilmMake make = make_film(all_effects());
  check_all(make.amplitude_v, {3.7456778975, 3.883935655845, 3.619611239932, 3.521385508193});
  check_all(make.sensitivity, {0.813986814589, 1.166014533895, 0.822334009205, 0.908295194673});
  check_all(make.exponent, {1.615119027234, 2.084591947971, 3.673023561862, 0.8});
  check_all(make.friction, {1.064562716595, 1.237044496715, 0.946545570191, 1.445726216016});
  check_all(make.lift_off_psi, {0.669794155126, 0.772802963965, 0.331196017569, 0.48051954377});
  check_all(make.zero_v, {0.017505547547, 0.019121714374, 0.018686625977, 0.019489405321});
  check_all(make.creep, {1.077430909271, 0.867671760269, 1.361604383073, 0.968076615493});
  check_all(make.lag_share, {0.05759891188, 0.074908171853, 0.061076946405, 0.0512755351});
  check_all(make.age_drift, {-0.121588037167, -0.508590318406, -0.755657386092, -0.254415001565});
  check_all({make.rest_share.begin(), make.rest_share.end()},
            {0.3958107531057428, 0.2943885696936741, 0.18691948008891962, 0.09164001479295174, 0.028115136636711786,
             0.0031260456820000385});
  check_all({make.displaced_share.begin(), make.displaced_share.end()},
            {0.0034597651172115383, 0.013403443390613027, 0.04200287623348465, 0.11951530863266059, 0.29917673824788665,
             0.5224418683781435});
  check_all(shares_of_chamber(all_effects()),
            {1.114317171358, 1.058612738328, 0.683870970351, 0.142342647032, 1.116691052294, 1.051888242881,
             0.712282360174, 0.127955470307, 1.213015902434, 1.001789943066, 0.662412110749, 0.1527998766});
}

TEST_CASE("specimen numbers: an array of one taxel has no neighbours, no tilt and no corner") {
  SpecimenOptions options;
  options.rows = options.columns = 1;
  options.sensor_seed = 2;
  options.effects.chamber_nonuniformity = 0.2;
  options.effects.chamber_tilt = 0.1;
  options.effects.row_crosstalk = options.effects.column_crosstalk = 0.5;
  Specimen specimen(options);
  specimen.advance(30.0, 1.0);
  std::vector<double> volts(1);
  specimen.output(volts);
  CHECK(volts[0] == close_to(2.415829427590805));
  CHECK(shares_of_chamber(options) == std::vector<double>{1.0});
}

TEST_CASE("specimen numbers: which taxel of the film each lead reads, for each way to lie") {
  SpecimenOptions options;
  options.rows = options.columns = 3;
  using Wiring = std::vector<std::size_t>;
  const auto wired = [&](MountTurn turn) {
    options.mount_turn = turn;
    return turned_wiring(options);
  };
  CHECK(wired(MountTurn::kNone) == Wiring{0, 1, 2, 3, 4, 5, 6, 7, 8});
  CHECK(wired(MountTurn::kBy90) == Wiring{6, 3, 0, 7, 4, 1, 8, 5, 2});
  CHECK(wired(MountTurn::kBy180) == Wiring{8, 7, 6, 5, 4, 3, 2, 1, 0});
  CHECK(wired(MountTurn::kBy270) == Wiring{2, 5, 8, 1, 4, 7, 0, 3, 6});
  CHECK(wired(MountTurn::kRowsMirrored) == Wiring{6, 7, 8, 3, 4, 5, 0, 1, 2});
  CHECK(wired(MountTurn::kColumnsMirrored) == Wiring{2, 1, 0, 5, 4, 3, 8, 7, 6});
  CHECK(wired(MountTurn::kTransposed) == Wiring{0, 3, 6, 1, 4, 7, 2, 5, 8});
  CHECK(wired(MountTurn::kAntiTransposed) == Wiring{8, 5, 2, 7, 4, 1, 6, 3, 0});
  for (const auto& [rows, columns] : {std::pair{3, 4}, std::pair{4, 3}}) {
    options.rows = rows;
    options.columns = columns;
    for (const MountTurn quarter :
         {MountTurn::kBy90, MountTurn::kBy270, MountTurn::kTransposed, MountTurn::kAntiTransposed})
      CHECK_THROWS_AS(wired(quarter), std::invalid_argument);
  }
  CHECK(wired(MountTurn::kBy180).front() == 11);
  CHECK(mount_turn_words(true).size() == 8);
  CHECK(mount_turn_words(false).size() == 4);
  CHECK(mount_turn_words(true)[4] == "turned-90");
  CHECK(mount_edge_words()[3] == "last-column");
}

TEST_CASE("specimen numbers: lines outside the membrane, at each edge") {
  SpecimenOptions options;
  options.rows = 3;
  options.columns = 2;
  options.edge_outside_lines = 2;
  const auto shares = [&](MountEdge edge) {
    options.edge_outside = edge;
    return shares_of_chamber(options);
  };
  check_all(shares(MountEdge::kFirstRow), {0.125, 0.125, 0.625, 0.625, 1.0, 1.0});
  check_all(shares(MountEdge::kLastRow), {1.0, 1.0, 0.625, 0.625, 0.125, 0.125});
  check_all(shares(MountEdge::kFirstColumn), {0.125, 0.625, 0.125, 0.625, 0.125, 0.625});
  check_all(shares(MountEdge::kLastColumn), {0.625, 0.125, 0.625, 0.125, 0.625, 0.125});
  options.edge_outside_lines = 1;
  check_all(shares(MountEdge::kFirstRow), {0.25, 0.25, 1.0, 1.0, 1.0, 1.0});
}

TEST_CASE("specimen numbers: noise goes with a swapped taxel and a turned film, what is refused names the place") {
  SpecimenOptions options;
  options.rows = 2;
  options.columns = 3;
  using Kind = TaxelDefect::Kind;
  options.defects = {{Kind::kNoisy, 0, 1, 0, 0}, {Kind::kSwapped, 0, 1, 1, 2}};
  const auto noisy = [&] {
    const Specimen specimen(options);
    std::vector<int> taxels;
    for (int i = 0; i < 6; ++i) {
      if (specimen.noise_v(i) == 0.05) taxels.push_back(i);
    }
    return taxels;
  };
  CHECK(noisy() == std::vector<int>{5});
  options.mount_turn = MountTurn::kBy180;
  CHECK(noisy() == std::vector<int>{0});
  for (const auto& [row, column] : {std::pair{-1, 0}, std::pair{2, 0}, std::pair{0, -1}, std::pair{0, 3}}) {
    options.defects = {{Kind::kDead, row, column, 0, 0}};
    CHECK_THROWS_AS(Specimen(options), std::invalid_argument);
    options.defects = {{Kind::kSwapped, 0, 0, row, column}};
    CHECK_THROWS_AS(Specimen(options), std::invalid_argument);
  }
  options.defects.clear();
  Specimen specimen(options);
  CHECK_THROWS_AS(specimen.advance(1.0, 0.0), std::invalid_argument);
  CHECK_THROWS_AS(specimen.advance(1.0, 1.0, std::vector<double>(5)), std::invalid_argument);
  std::vector<double> short_of_one(5);
  CHECK_THROWS_AS(specimen.output(short_of_one), std::invalid_argument);
  for (const auto& [rows, columns] : {std::pair{0, 3}, std::pair{2, 0}}) {
    options.rows = rows;
    options.columns = columns;
    CHECK_THROWS_AS(Specimen(options), std::invalid_argument);
  }
}
