// The harsh film in numbers: what another implementation of its equations (bench/simulation/README.md) gives for the
// same seeds, in Python, to twelve digits. A deliberate change of the film changes them.
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>

#include "bench/simulation/counter_noise.h"
#include "bench/simulation/specimen.h"
#include "bench/simulation/specimen_harsh.h"
#include "tests/bench/simulation/harsh_sensor.h"

namespace tactbench::bench::testing {
namespace {

void check_twelve(const std::vector<double>& made, const std::vector<double>& expected) {
  REQUIRE(made.size() >= expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    INFO("value " << i);
    CHECK(made[i] == Approx(expected[i]).epsilon(0.0).margin(2e-11 * std::max(1.0, std::abs(expected[i]))));
  }
}

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

TEST_CASE("harsh specimen numbers: unloaded, after a walk, under an object, and an eighth of an hour later") {
  Specimen specimen(twelve_taxels());
  check_twelve(output_of(specimen, 12), {0.04298059769871, 0.04298511731571, 0.04582562989403, 0.04883701428873,
                                         0.04713779989988, 0.04905148751222, 0.05367611912136, 0.05068407402583,
                                         0.04863676429244, 0.04120234333682, 0.0675999024141, 0.0606358672845});
  for (const auto& [psi, seconds] : std::vector<std::pair<double, double>>{
           {20, 1.0}, {60, 2.0}, {35, 0.5}, {0, 3.0}, {10, 1.0}, {25, 0.7}, {25, 40.0}, {12, 1.5}})
    specimen.advance(psi, seconds);
  check_twelve(output_of(specimen, 12),
               {1.152011221912, 2.269805163365, 1.057279938586, 1.395489731168, 1.580121894012, 2.683032725243,
                2.537104963723, 0.4544821363863, 1.541855258566, 1.778103232252, 2.369612168668, 1.273918578005});
  const auto state = nlohmann::json::parse(specimen.state());
  const auto& own = state["harsh"];
  check_twelve({own["path_psi"].get<double>(), own["time_s"].get<double>()}, {233.1346979173, 49.7});
  check_twelve(own["zero_walk_v"].get<std::vector<double>>(),
               {-0.009597525543139, -0.01526816165783, -0.01015270140266, -0.009599668509643, -0.01362355738559,
                -0.01317545860598, -0.005698663800859, -0.01082806909305, -0.01560450276258, -0.008886860135478,
                -0.001641432434864, -0.007187851848284});
  check_twelve(own["gain_walk"].get<std::vector<double>>(),
               {0.007201788676297, -0.00906266477576, 0.0005348288362749, 0.001012806786767, 0.004900967656339,
                0.003722386877753, 0.00220386367708, 0.00942107212949, 0.001201578222736, -0.0004300054829235,
                0.004394952466883, 0.0008820512120839});
  check_twelve(own["sliding"].get<std::vector<double>>(),
               {-0.321886925606, -0.40124062521, -0.2543292389376, -0.2547949457196});
  check_twelve(own["drag_psi"].get<std::vector<double>>(),
               {-0.5484437970629, -0.8578898364561, -0.3625989148047, -0.6300724165272});
  check_twelve(own["load_psi"].get<std::vector<double>>(),
               {9.397263357274, 13.41639315727, 9.782722927727, 10.63655398609});
  const auto creep = state["creep"].get<std::vector<std::vector<double>>>();
  REQUIRE(creep.size() == kHarshCreepTimes);
  check_twelve({creep[5][0], creep[3][1], creep[0][2]}, {0.003552776614643, 0.3050344266229, 0.6198375087691});
  std::vector<double> contact(12);
  for (std::size_t i = 0; i < 12; ++i) contact[i] = 0.5 * static_cast<double>(i);
  specimen.advance(15.0, 0.4, contact);
  check_twelve(output_of(specimen, 12),
               {1.197504650676, 2.344833593257, 1.232295770149, 1.435196659378, 1.687466888944, 2.963136713859,
                2.671357527351, 0.6562689263333, 1.689310046052, 2.32747383511, 2.686978828112, 1.543604379455});
  specimen.advance(15.0, 400.0);  // forty knots of the walks
  check_twelve(output_of(specimen, 12),
               {1.252775001549, 2.427785086196, 1.239668608481, 1.464753504935, 1.721761972815, 2.99426236304,
                2.717526803805, 0.5728021155033, 1.706932633522, 2.115752195758, 2.579301678902, 1.494862176656});
}

TEST_CASE("harsh specimen numbers: 1/f noise as a share of the output, and heavy tails of single samples") {
  const Specimen specimen(twelve_taxels());
  const auto flicker_at = [&](double time_s) {
    std::vector<double> volts(12, 2.0);
    specimen.add_film_noise(time_s, volts);
    for (double& v : volts) v = v / 2.0 - 1.0;
    return volts;
  };
  check_twelve(flicker_at(0.0), {-0.001262708805285, 0.0005907356757375, -0.001369143665714, -0.0009280621907061});
  check_twelve(flicker_at(100.3), {0.00107315799848, -0.0003607905802993, -0.0004237876775586, 0.001410085840478});
  check_twelve(flicker_at(5000.25), {-0.0001409989620782, 0.001586881132175, 0.0008200021139462, -0.00126364024814});
  const std::vector<double> expected{-0.3518822434729, 0.4937634305669, 0.0168537763544,
                                     -0.4452185112315, 0.3213488290319, -1.09606095564};
  std::vector<double> drawn, through_film;
  for (std::uint64_t i = 0; i < expected.size(); ++i) {
    drawn.push_back(heavy_tailed_of(hash_of(1, 2, i)));
    through_film.push_back(specimen.white_noise(hash_of(1, 2, i)));
  }
  check_twelve(drawn, expected);
  CHECK(through_film == drawn);
}

}  // namespace tactbench::bench::testing
