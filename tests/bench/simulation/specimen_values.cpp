// The simulated film in numbers: what another implementation of its equations (bench/simulation/README.md) gives for
// the same seeds, in Python, to twelve digits. A deliberate change of the film changes them.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <span>
#include <stdexcept>

#include "bench/simulation/counter_noise.h"
#include "bench/simulation/specimen.h"
#include "bench/simulation/specimen_film.h"
#include "bench/simulation/specimen_harsh.h"
#include "tests/bench/simulation/specimen_runs.h"

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

TEST_CASE("specimen values: all effects and defects together, and the film memory") {
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

TEST_CASE("specimen values: parameters of the film of an array, and its shares of the chamber pressure") {
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

TEST_CASE("specimen values: an array of one taxel has no neighbours, no tilt and no corner") {
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

TEST_CASE("specimen values: which taxel of the film each lead reads, for each orientation") {
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
  CHECK(mount_turn_names(true).size() == 8);
  CHECK(mount_turn_names(false).size() == 4);
  CHECK(mount_turn_names(true)[4] == "turned-90");
  CHECK(mount_edge_names()[3] == "last-column");
}

TEST_CASE("specimen values: lines outside the membrane, at each edge") {
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

TEST_CASE("specimen values: noise moves with a swapped taxel and a turned film, invalid defects are rejected") {
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

// The specimen against the figures of the paper's sensor: hysteresis of the mean taxel, full scale, Table 6.

namespace tactbench::bench::testing {
namespace {

struct Cell {
  double pressure_psi;
  double std_over_full_scale;
};
// Table 6; the cell at 59.93 psi is the turning point.
constexpr std::array<Cell, 7> kUp = {
    {{4.01, 0.09}, {10.25, 0.16}, {20.2, 0.18}, {30.06, 0.15}, {40.2, 0.13}, {49.9, 0.12}, {59.93, 0.11}}};
constexpr std::array<Cell, 6> kDown = {
    {{4.01, 0.13}, {10.05, 0.18}, {19.86, 0.16}, {30.01, 0.13}, {40.02, 0.12}, {49.59, 0.11}}};

double at(const std::vector<double>& levels, double pressure_psi) {
  const double place = pressure_psi / kStepPsi;
  const auto below = std::min(static_cast<std::size_t>(place), levels.size() - 2);
  return levels[below] + (place - static_cast<double>(below)) * (levels[below + 1] - levels[below]);
}

struct Figures {
  double full_scale_v = 0, max_percent = 0, mean_percent = 0, top_fall_percent = 0, highest_v = 0, lowest_v = 5;
  bool monotone = true;
  int falling_taxels = 0;  // with a sample of an outer branch below the one before, in pressure
  std::vector<double> up_std, down_std;
};

// Conditioning, five repeats of both sequences, the external loop of the last repeat.
Figures measure(std::uint64_t sensor_seed) {
  SpecimenOptions options;
  options.sensor_seed = sensor_seed;
  Specimen specimen(options);
  Walker walker(specimen);
  walker.walk(kConditioning);
  Figures figures;
  std::vector<Frame> last;
  Frame zero;
  for (int repeat = 0; repeat < 5; ++repeat) {
    zero = walker.frame();
    last = walker.walk(kDescendingSet);
    REQUIRE(last.size() + 1 == 211);
  }
  for (int repeat = 0; repeat < 5; ++repeat) {
    const auto frames = walker.walk(kAscendingSet);
    REQUIRE(frames.size() + 1 == 451);
    for (const Frame& frame : frames) {
      figures.highest_v = std::max(figures.highest_v, *std::max_element(frame.begin(), frame.end()));
      figures.lowest_v = std::min(figures.lowest_v, *std::min_element(frame.begin(), frame.end()));
    }
  }
  std::vector<double> up{mean(zero)};
  std::vector<double> down(31);
  figures.up_std = {deviation(zero)};
  figures.down_std.resize(31);
  for (std::size_t k = 0; k < 30; ++k) {
    up.push_back(mean(last[k]));
    figures.up_std.push_back(deviation(last[k]));
  }
  for (std::size_t k = 0; k <= 30; ++k) {
    down[30 - k] = mean(last[29 + k]);
    figures.down_std[30 - k] = deviation(last[29 + k]);
  }
  const double full_scale = *std::max_element(up.begin(), up.end());
  figures.full_scale_v = full_scale;
  for (std::size_t i = 0; i < 256; ++i) {
    bool falls = last[0][i] < zero[i];
    for (std::size_t k = 1; k < 30; ++k) falls = falls || last[k][i] < last[k - 1][i];
    for (std::size_t k = 30; k < 60; ++k) falls = falls || last[k][i] > last[k - 1][i];
    figures.falling_taxels += falls ? 1 : 0;
  }
  for (std::size_t k = 0; k <= 30; ++k) {
    const double gap = 100.0 * (down[k] - up[k]) / full_scale;
    figures.max_percent = std::max(figures.max_percent, gap);
    figures.mean_percent += gap / 31.0;
    figures.up_std[k] /= full_scale;
    figures.down_std[k] /= full_scale;
    if (k > 0 && (up[k] <= up[k - 1] || down[k] <= down[k - 1])) figures.monotone = false;
  }
  figures.top_fall_percent = 100.0 * (down[30] - down[25]) / full_scale;
  return figures;
}

void check_cells(const char* name, const std::vector<double>& levels, std::span<const Cell> cells) {
  for (const Cell& cell : cells) {
    INFO(name << ' ' << cell.pressure_psi << " psi");
    const double got = at(levels, cell.pressure_psi);
    CHECK(got == Approx(cell.std_over_full_scale).margin(0.03));
  }
}

}  // namespace

TEST_CASE("specimen: agrees with the published values of the paper sensor, sensor seeds 1 to 5") {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    CAPTURE(seed);
    const Figures f = measure(seed);
    CHECK(f.full_scale_v == Approx(3.5).margin(0.05));
    CHECK(f.max_percent == Approx(25.3).margin(1.5));
    CHECK(f.mean_percent == Approx(10.0).margin(1.2));
    CHECK(f.top_fall_percent > 0.8);  // the slope stays observable ...
    CHECK(f.top_fall_percent < 2.0);  // ... in a saturated curve
    CHECK(f.monotone);
    CHECK(f.falling_taxels == 0);
    CHECK(f.lowest_v >= 0.0);
    CHECK(f.highest_v < 4.9);
    check_cells("up", f.up_std, kUp);
    check_cells("down", f.down_std, kDown);
  }
}

// The harsh film in numbers: what another implementation of its equations (bench/simulation/README.md) gives for the
// same seeds, in Python, to twelve digits. A deliberate change of the film changes them.

namespace {

SpecimenOptions twelve_taxels() {
  SpecimenOptions options = harsh_sensor(9, 4);
  options.rows = 3;
  options.columns = 4;
  options.effects.lift_off_psi = 0.5;
  return options;
}

std::vector<double> output_of(const Specimen& specimen, std::size_t taxels) {
  std::vector<double> volts(taxels);
  specimen.output(volts);
  return volts;
}

}  // namespace

TEST_CASE("harsh specimen values: unloaded, after a path of loads, under an object, and 450 s later") {
  Specimen specimen(twelve_taxels());
  check_all(output_of(specimen, 12),
            {0.04298059769871, 0.04298511731571, 0.04582562989403, 0.04883701428873, 0.04713779989988, 0.04905148751222,
             0.05367611912136, 0.05068407402583, 0.04863676429244, 0.04120234333682, 0.0675999024141, 0.0606358672845});
  for (const auto& [psi, seconds] : std::vector<std::pair<double, double>>{
           {20, 1.0}, {60, 2.0}, {35, 0.5}, {0, 3.0}, {10, 1.0}, {25, 0.7}, {25, 40.0}, {12, 1.5}})
    specimen.advance(psi, seconds);
  check_all(output_of(specimen, 12),
            {1.152011221912, 2.269805163365, 1.057279938586, 1.395489731168, 1.580121894012, 2.683032725243,
             2.537104963723, 0.4544821363863, 1.541855258566, 1.778103232252, 2.369612168668, 1.273918578005});
  const auto state = nlohmann::json::parse(specimen.state());
  const auto& own = state["harsh"];
  check_all({own["path_psi"].get<double>(), own["time_s"].get<double>()}, {233.1346979173, 49.7});
  check_all(own["zero_walk_v"].get<std::vector<double>>(),
            {-0.009597525543139, -0.01526816165783, -0.01015270140266, -0.009599668509643, -0.01362355738559,
             -0.01317545860598, -0.005698663800859, -0.01082806909305, -0.01560450276258, -0.008886860135478,
             -0.001641432434864, -0.007187851848284});
  check_all(own["gain_walk"].get<std::vector<double>>(),
            {0.007201788676297, -0.00906266477576, 0.0005348288362749, 0.001012806786767, 0.004900967656339,
             0.003722386877753, 0.00220386367708, 0.00942107212949, 0.001201578222736, -0.0004300054829235,
             0.004394952466883, 0.0008820512120839});
  check_all(own["sliding"].get<std::vector<double>>(),
            {-0.321886925606, -0.40124062521, -0.2543292389376, -0.2547949457196});
  check_all(own["drag_psi"].get<std::vector<double>>(),
            {-0.5484437970629, -0.8578898364561, -0.3625989148047, -0.6300724165272});
  check_all(own["load_psi"].get<std::vector<double>>(),
            {9.397263357274, 13.41639315727, 9.782722927727, 10.63655398609});
  const auto creep = state["creep"].get<std::vector<std::vector<double>>>();
  REQUIRE(creep.size() == kHarshCreepTimes);
  check_all({creep[5][0], creep[3][1], creep[0][2]}, {0.003552776614643, 0.3050344266229, 0.6198375087691});
  std::vector<double> contact(12);
  for (std::size_t i = 0; i < 12; ++i) contact[i] = 0.5 * static_cast<double>(i);
  specimen.advance(15.0, 0.4, contact);
  check_all(output_of(specimen, 12),
            {1.197504650676, 2.344833593257, 1.232295770149, 1.435196659378, 1.687466888944, 2.963136713859,
             2.671357527351, 0.6562689263333, 1.689310046052, 2.32747383511, 2.686978828112, 1.543604379455});
  specimen.advance(15.0, 400.0);  // forty knots of the walks
  check_all(output_of(specimen, 12),
            {1.252775001549, 2.427785086196, 1.239668608481, 1.464753504935, 1.721761972815, 2.99426236304,
             2.717526803805, 0.5728021155033, 1.706932633522, 2.115752195758, 2.579301678902, 1.494862176656});
}

TEST_CASE("harsh specimen values: 1/f noise as a share of the output, and heavy tails of single samples") {
  const Specimen specimen(twelve_taxels());
  const auto flicker_at = [&](double time_s) {
    std::vector<double> volts(12, 2.0);
    specimen.add_film_noise(time_s, volts);
    for (double& v : volts) v = v / 2.0 - 1.0;
    return volts;
  };
  check_all(flicker_at(0.0), {-0.001262708805285, 0.0005907356757375, -0.001369143665714, -0.0009280621907061});
  check_all(flicker_at(100.3), {0.00107315799848, -0.0003607905802993, -0.0004237876775586, 0.001410085840478});
  check_all(flicker_at(5000.25), {-0.0001409989620782, 0.001586881132175, 0.0008200021139462, -0.00126364024814});
  const std::vector<double> expected{-0.3518822434729, 0.4937634305669, 0.0168537763544,
                                     -0.4452185112315, 0.3213488290319, -1.09606095564};
  std::vector<double> drawn, through_film;
  for (std::uint64_t i = 0; i < expected.size(); ++i) {
    drawn.push_back(heavy_tailed_of(hash_of(1, 2, i)));
    through_film.push_back(specimen.white_noise(hash_of(1, 2, i)));
  }
  check_all(drawn, expected);
  CHECK(through_film == drawn);
}

}  // namespace tactbench::bench::testing
