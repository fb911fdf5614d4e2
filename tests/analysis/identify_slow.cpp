// The fast search against a dense one that shares only the samples with it.
#include <catch2/catch.hpp>

#include "analysis/identify/identify.h"
#include "tests/analysis/support/dense_reference.h"
#include "tests/analysis/support/synthetic.h"

using namespace synthetic;

TEST_CASE("identification finds what a dense search of the whole box finds") {
  for (const double noise : {0.0015, 0.012}) {
    ArrayOptions array;
    array.rows = 4;
    array.columns = 3;
    array.sensor_seed = 77;
    RunOptions options;
    options.noise_v = noise;
    const Dataset data = run(Array(array), options);
    std::vector<CommonSequence> sequences;
    for (const SequenceData& sequence : data.sequences) sequences.push_back(bring_to_common(sequence, data.taxels()));
    const ArrayFit fit = fit_array(data);
    const auto width = static_cast<std::size_t>(data.taxels());
    double sum = 0.0, reference_sum = 0.0;
    for (std::size_t taxel = 0; taxel < width; ++taxel) {
      std::vector<TaxelBranch> branches;
      for (const CommonSequence& sequence : sequences) {
        for (const Branch& branch : sequence.branches) {
          TaxelBranch own{branch.ascending, {}, {}};
          for (auto i = static_cast<std::size_t>(branch.first); i <= static_cast<std::size_t>(branch.last); ++i) {
            own.pressure_psi.push_back(sequence.pressure_psi[i]);
            own.volts.push_back(sequence.volts[i * width + taxel]);
          }
          branches.push_back(std::move(own));
        }
      }
      ElamModel model = fit.taxels[taxel].fit.model;
      const ElamSamples samples = collect_samples(model, branches);
      const double reference = dense_reference(model, samples.descending, false) +
                               dense_reference(model, samples.ascending, true) + samples.ascending_constant +
                               samples.descending_constant;
      const double j = fit.taxels[taxel].fit.j_v2;
      INFO("taxel " << taxel << ", J " << j << ", dense " << reference);
      CHECK(j <= reference * (1.0 + 1e-3));
      sum += j;
      reference_sum += reference;
    }
    WARN("noise " << noise << " V: sum of J over the dense search's " << sum / reference_sum);
    CHECK(sum <= reference_sum * (1.0 + 1e-5));
  }
}
