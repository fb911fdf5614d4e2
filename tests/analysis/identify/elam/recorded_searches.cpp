// ELAM on few samples of models drawn anywhere: where the search ended when these were recorded. `verify` recomputes
// stored fits by later programs, which have to end in the same places (small_problems.cpp looks at J alone).
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "analysis/identify/elam/identify.h"
#include "tests/analysis/support/synthetic.h"

using namespace synthetic;

namespace {

// From inner turns and the ends, three to five samples a branch, `noise` V off; parameters within low..high.
std::vector<TaxelBranch> sparse_branches(Random& random, double noise, double low, double high) {
  const double u = random(low, high), v = random(low, high), alpha_d = random(low, high), beta_d = random(low, high);
  const ElamModel truth = model_of(paper_loop(), {alpha_d, beta_d, (v - u) / 60.0, u, random(low, high)});
  std::vector<TaxelBranch> branches;
  for (const bool up : {false, true})
    for (int n = 0; n < 3; ++n) {
      const double turn = n == 0 ? (up ? 0.0 : 60.0) : n == 1 ? random(15.0, 45.0) : random(10.0, 50.0);
      const double start = (up ? truth.descending : truth.ascending)(turn), end = up ? 60.0 : 0.0;
      const ElamCurve curve(truth, up, turn, start);
      TaxelBranch& branch = branches.emplace_back(TaxelBranch{up, {turn}, {start}});
      const int samples = 3 + static_cast<int>(random(0.0, 2.99));
      for (int i = 1; i <= samples; ++i) {
        const double x = turn + (end - turn) * i / samples;
        branch.pressure_psi.push_back(x);
        branch.volts.push_back(curve.output(x) + random(-noise, noise));
      }
    }
  return branches;
}

struct Recorded {
  unsigned undetermined;
  double j, alpha_d, beta_d, alpha_a1, alpha_a0, beta_a;
};

ElamFit sparse_fit(Random& random, int problem, bool settle) {
  const bool near_one = problem % 2 == 1;
  const std::vector<TaxelBranch> branches =
      sparse_branches(random, problem % 3 == 0 ? 0.2 : 0.8, near_one ? 0.9 : 0.02, near_one ? 1.0 : 0.98);
  const ElamModel like = model_of(paper_loop(), {});
  return identify_elam(like.ascending, like.descending, branches, {}, settle);
}

const std::vector<Recorded> kSearched{
    {0, 0.26307330726, 0.8, 0.42801916975, -0.0013254375994, 0.46413399803, 0.45406954368},
    {0, 3.3609152281, 0.6, 0.84293230136, -0.005410988015, 0.41175808963, 0},
    {0, 3.5815953362, 0.45769997979, 0.087453263275, 0.013333333889, 0, 0.73569768943},
    {0, 0.23719819941, 0.85393885562, 0.91879512686, -0.0026850875547, 0.76110525384, 0.81332596785},
    {0, 5.1162647351, 0.29542866059, 1, -0.01228975802, 0.97676338714, 0.44816033717},
    {0, 2.6048184108, 0.79636341472, 0.73029887945, 0.0063077276656, 0, 0.32979942698},
    {0, 0.2423515963, 0.2, 0.77258720172, -0.008095883165, 0.65595790801, 0.36925838637},
    {0, 6.1571117366, 1, 0.91807841699, -0.0099999999988, 1, 0.75026952274},
    {0, 3.5385844421, 0.70073198994, 0.45515615874, 0.0066666666584, 0, 0.56798180537},
    {0, 0.31745403744, 0.99606283182, 0.9567539391, 0.00044031432977, 0.18147540848, 0.39715526083},
    {0, 5.4991506951, 0.19842519685, 1, -0.011352671711, 1, 0},
    {0, 5.1164905241, 1, 0.99020394983, 0.011111112777, 0, 0.80184911887},
    {0, 0.30268622645, 0.8, 0.12881046362, 0.006517915937, 0, 0.63667621539},
    {0, 3.3107991298, 0.75000000004, 0.86259476838, 0.0041666698359, 0, 0.6366771957},
    {0, 5.7902652433, 0, 0.42705923993, -0.0033333333462, 1, 0.98849418639},
    {0, 0.28381962793, 0.87051430394, 0.97567420829, 0.0047241725896, 0.71654964463, 0.90690580853},
    {0, 4.7301777013, 0.36517534539, 0.29152084032, 0.016413342641, 0.015199441548, 0},
    {0, 5.0094979348, 1, 0.97177518213, -0.0055555542856, 1, 0.81890995401},
    {0, 0.17058529445, 0.19745995648, 0.34558034009, 0.014085476554, 0, 0.0819876979},
    {0, 2.2657785392, 1, 1, -0.0050425706626, 0.43171644659, 0},
    {0, 3.3509018215, 0.64783544818, 0.39185712987, 0.0055555555505, 0, 0.47516342729},
    {0, 0.2168487528, 1, 0.92016064734, 0.0040039534299, 0.25976279424, 0.74209686306},
    {0, 4.4844698603, 0.73451383748, 0.69696623076, -0.016167552283, 1, 0},
    {0, 4.7246790906, 0.66666666677, 0.88408615514, -0.01542845654, 0.97299919389, 0},
    {0, 0.28043679741, 0.52574949587, 0.46586785269, 0.016666666667, 0, 0.30383825965},
    {0, 5.0448174402, 1, 0.85276671717, -0.0090992910861, 0.69011775692, 0},
    {0, 2.5920718601, 0.37522568271, 0.70573956205, 0.011545816596, 0, 0.57394332749},
    {0, 0.36566883738, 1, 0.92343445238, 0.013333333681, 0, 0.83339463704},
    {0, 2.9712397735, 0.4515249591, 0.068039115065, 0.0080437600645, 0.10387295953, 0.24350025662},
    {0, 3.197095916, 0.53917931484, 1, 0.015454026386, 0, 0.99956119339},
    {0, 0.16031618554, 0, 0.84646249476, -0.010697334122, 0.85214634041, 0.062053532701},
    {0, 3.2871377572, 0.17490963091, 0.53754748335, -0.002275255198, 0.48964510557, 0.32657071606},
};

// The same with what the samples leave open settled near the pattern's middle.
const std::vector<Recorded> kSettled{
    {8, 0.26307330726, 0.8, 0.42801916975, -0.0013254375994, 0.46413399803, 0.45406954368},
    {29, 3.7492539205, 0.6, 0.84293230136, 0, 0.5, 0.79570200573},
    {8, 3.5815953362, 0.45769997979, 0.087453263275, 0.013333333889, 0, 0.73569768943},
    {28, 0.33548801624, 0.85393885562, 0.91879512686, 0, 0.5, 0.79570200573},
    {28, 5.1901220508, 0.29542866059, 1, 0, 0.5, 0.79570200573},
    {28, 4.0498472728, 0.79636341472, 0.73029887945, 0, 0.5, 0.79570200573},
    {28, 0.27366585295, 0.2, 0.77258720172, 0, 0.5, 0.79570200573},
    {31, 7.6791803098, 0.5, 0.89541547278, 0, 0.5, 0.79570200573},
    {28, 3.9433328052, 0.70073198994, 0.45515615874, 0, 0.5, 0.79570200573},
    {28, 0.32473827592, 0.99606283182, 0.9567539391, 0, 0.5, 0.79570200573},
    {9, 5.4991506951, 0.19842519685, 1, -0.011352671711, 1, 0},
    {29, 6.3916521494, 0.5, 0.89541547278, 0, 0.5, 0.79570200573},
    {28, 0.42851798358, 0.8, 0.12881046362, 0, 0.5, 0.79570200573},
    {28, 3.6211621231, 0.75000000004, 0.86259476838, 0, 0.5, 0.79570200573},
    {31, 5.9320996148, 0, 0.42705923993, 0, 0.5, 0.79570200573},
    {28, 0.28381962793, 0.87051430394, 0.97567420829, 0.0047241725896, 0.71654964463, 0.90690580853},
    {12, 4.7301777013, 0.36517534539, 0.29152084032, 0.016413342641, 0.015199441548, 0},
    {29, 5.2846845867, 1, 0.97177518213, 0, 0.5, 0.79570200573},
    {10, 0.17058529445, 0.19745995648, 0.34558034009, 0.014085476554, 0, 0.0819876979},
    {29, 2.9304323445, 1, 1, 0, 0.5, 0.79570200573},
    {28, 3.7691798106, 0.64783544818, 0.39185712987, 0, 0.5, 0.79570200573},
    {28, 0.3186381469, 1, 0.92016064734, 0, 0.5, 0.79570200573},
    {28, 4.9747014438, 0.73451383748, 0.69696623076, 0, 0.5, 0.79570200573},
    {31, 5.291520003, 0.5, 0.89541547278, 0, 0.5, 0.79570200573},
    {12, 0.28043679741, 0.52574949587, 0.46586785269, 0.016666666667, 0, 0.30383825965},
    {31, 8.8515880292, 0.5, 0.89541547278, 0, 0.5, 0.79570200573},
    {11, 2.9280748937, 0.5, 0.89541547278, 0.011545816596, 0, 0.57394332749},
    {8, 0.36566883738, 1, 0.92343445238, 0.013333333681, 0, 0.83339463704},
    {8, 2.9712397735, 0.4515249591, 0.068039115065, 0.0080437600645, 0.10387295953, 0.24350025662},
    {28, 3.3828005491, 0.53917931484, 1, 0, 0.5, 0.79570200573},
    {3, 0.16031618554, 0, 0.84646249476, -0.010697334122, 0.85214634041, 0.062053532701},
    {31, 5.069195508, 0.5, 0.89541547278, 0, 0.5, 0.79570200573},
};

void check_recorded(const std::vector<Recorded>& recorded, bool settle) {
  Random random(7);
  for (std::size_t problem = 0; problem < recorded.size(); ++problem) {
    CAPTURE(problem);
    const ElamFit fit = sparse_fit(random, static_cast<int>(problem), settle);
    const ElamParameters& p = fit.model.parameters;
    const Recorded& was = recorded[problem];
    CHECK(fit.undetermined == was.undetermined);
    CHECK(fit.j_v2 == Approx(was.j).epsilon(1e-7));
    CHECK(p.alpha_d == Approx(was.alpha_d).epsilon(0.0).margin(1e-6));
    CHECK(p.beta_d == Approx(was.beta_d).epsilon(0.0).margin(1e-6));
    CHECK(p.alpha_a1 == Approx(was.alpha_a1).epsilon(0.0).margin(1e-7));
    CHECK(p.alpha_a0 == Approx(was.alpha_a0).epsilon(0.0).margin(1e-6));
    CHECK(p.beta_a == Approx(was.beta_a).epsilon(0.0).margin(1e-6));
  }
}

}  // namespace

TEST_CASE("ELAM: searches of few noisy samples end where they ended when they were recorded") {
  check_recorded(kSearched, false);
}

TEST_CASE("ELAM: what few noisy samples leave open is settled as it was when it was recorded") {
  check_recorded(kSettled, true);
}
