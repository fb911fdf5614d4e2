// From stored frames to a dataset, and a fit to the store and back.
#include <catch2/catch.hpp>
#include <cmath>

#include "analysis/dataset.h"
#include "analysis/identify/stored/model_document.h"
#include "analysis/statistics/figures/evaluation.h"
#include "db/run_store.h"
#include "tests/analysis/support/fit_samples.h"
#include "tests/support/process.h"

using namespace synthetic;
namespace db = tactbench::db;

namespace {

constexpr double kScale = 5.0 / 65535.0;

class AnalysedStore {
 public:
  AnalysedStore() : store_(db::RunStore::open(folder_.path("runs.db"), db::Durability::kNormal)) {}
  db::RunStore& operator*() { return store_; }
  db::RunStore* operator->() { return &store_; }

 private:
  tactbench::tests::TemporaryFolder folder_;
  db::RunStore store_;
};

std::int64_t begin(db::RunStore& store, const std::vector<db::SequenceRecord>& sequences) {
  if (!store.sensor("S1")) store.add_sensor({"S1", "type", "a = 1", db::sha256_hex("a = 1"), "C1", "", ""});
  db::RunRecord run;
  run.uuid = db::new_uuid();
  run.origin = "simulated";
  run.state = "prepared";
  run.sensor_serial = "S1";
  run.scanner_serial = "C1";
  run.sequences = sequences;
  run.devices = {{"tactile scanner", "m", "C1", "1", "simulated", R"({"volts_per_count": 7.62951094834821e-05})"}};
  return store.begin_run(run);
}

db::FrameRecord frame(std::int64_t branch, int ordinal, double level, std::vector<std::uint16_t> counts, int scans,
                      int rows, int columns) {
  db::FrameRecord record;
  record.branch = branch;
  record.ordinal = ordinal;
  record.setpoint_psi = level;
  record.reference_psi = level + 0.1;
  record.rows = rows;
  record.columns = columns;
  record.scans = scans;
  record.counts = std::move(counts);
  return record;
}

// One taxel pair, levels 0 2 0 in two branches per repeat; the counts tell repeat and step.
void record_repeat(db::RunStore& store, std::int64_t run, int repeat, int frames = 3, int attempt = 0) {
  const double levels[] = {0.0, 2.0, 0.0};
  std::int64_t branch = 0;
  for (int i = 0; i < frames; ++i) {
    if (i != 1)
      branch = store.begin_branch(run, {0, 0, repeat, i / 2, attempt, false, "", i < 2 ? 0.0 : 2.0, i < 2 ? 2.0 : 0.0});
    const auto base = static_cast<std::uint16_t>(1000 * repeat + 100 * i + 10);
    const auto next = static_cast<std::uint16_t>(base + 4);
    store.append_frame(run, frame(branch, i, levels[i], {base, 7, next, 7}, 2, 1, 2));
  }
}

const std::vector<db::SequenceRecord> kTiny{{0, "tiny", "r = 1", "", 3, 3}};

// A whole synthetic run through the store.
std::int64_t record_dataset(db::RunStore& store, const Dataset& data) {
  std::vector<db::SequenceRecord> sequences;
  for (std::size_t s = 0; s < data.sequences.size(); ++s)
    sequences.push_back({static_cast<int>(s), data.sequences[s].name, "r = 1", "",
                         static_cast<int>(data.sequences[s].repeats.size()),
                         static_cast<int>(data.sequences[s].repeats[0].steps.size())});
  const std::int64_t run = begin(store, sequences);
  const auto width = static_cast<std::size_t>(data.taxels());
  for (std::size_t s = 0; s < data.sequences.size(); ++s) {
    for (std::size_t r = 0; r < data.sequences[s].repeats.size(); ++r) {
      const Repeat& repeat = data.sequences[s].repeats[r];
      const auto branch =
          store.begin_branch(run, {0, static_cast<int>(s), static_cast<int>(r), 0, 0, false, "", 0.0, 60.0});
      for (std::size_t i = 0; i < repeat.steps.size(); ++i) {
        std::vector<std::uint16_t> counts;
        for (std::size_t taxel = 0; taxel < width; ++taxel)
          counts.push_back(static_cast<std::uint16_t>(
              std::clamp(std::lround(repeat.volts[i * width + taxel] / kScale), 0L, 65535L)));
        db::FrameRecord record =
            frame(branch, static_cast<int>(i), repeat.steps[i].setpoint_psi, counts, 1, data.rows, data.columns);
        record.reference_psi = repeat.steps[i].reference_psi;
        store.append_frame(run, record);
      }
    }
  }
  return run;
}

}  // namespace

TEST_CASE("load_dataset: volts come in step order, without void branches and incomplete repeats") {
  AnalysedStore store;
  const std::int64_t run = begin(*store, kTiny);
  const std::int64_t bad = store->begin_branch(run, {0, 0, 0, 0, 0, false, "", 0.0, 2.0});
  store->append_frame(run, frame(bad, 0, 0.0, {65535, 1, 65535, 1}, 2, 1, 2));
  store->void_branch(bad, "interrupted");
  record_repeat(*store, run, 0, 2, 1);
  CHECK(id_of_refusal([&] { return load_dataset(*store, run); }) == "TB-ANALYSIS-EMPTY");
  record_repeat(*store, run, 1);
  const Dataset data = load_dataset(*store, run);
  REQUIRE(data.sequences.size() == 1);
  REQUIRE(data.sequences[0].repeats.size() == 1);
  const Repeat& second = data.sequences[0].repeats[0];
  CHECK(second.steps[1].setpoint_psi == 2.0);
  CHECK(second.steps[1].reference_psi == 2.1);
  CHECK(second.volts[2] == Approx(1112.0 * kScale));  // mean of the two scans
  CHECK(second.volts[3] == Approx(7.0 * kScale));
  CHECK((data.origin == "simulated" && data.sensor_serial == "S1"));
  CHECK_FALSE(data.at_limit[0]);  // the void frame alone stood there
}

TEST_CASE("load_dataset: a sample contradicted by the other scan is dropped, two frames at the limit mean saturated") {
  AnalysedStore store;
  const std::int64_t run = begin(*store, {{0, "tiny", "r = 1", "", 1, 6}});
  const std::int64_t branch = store->begin_branch(run, {0, 0, 0, 0, 0, false, "", 0.0, 10.0});
  const std::uint16_t limit = 65535;
  for (int i = 0; i < 6; ++i) {
    const auto own = static_cast<std::uint16_t>(1000 * i + 10);
    std::vector<std::uint16_t> counts = {own, own, own, static_cast<std::uint16_t>(own + 4), own, own};
    if (i == 2) counts[3] = limit;              // taxel 0: one sample
    if (i == 3) counts[0] = 40000;              // and another
    if (i == 4) counts[1] = counts[4] = limit;  // taxel 1: one frame
    if (i >= 4) counts[2] = counts[5] = limit;  // taxel 2: two frames
    store->append_frame(run, frame(branch, i, 2.0 * i, counts, 2, 1, 3));
  }
  const Dataset data = load_dataset(*store, run);
  CHECK(data.outlying == 2);
  CHECK((data.at_limit == std::vector<bool>{false, false, true}));
  const std::vector<double>& volts = data.sequences[0].repeats[0].volts;
  CHECK(volts[2 * 3] == Approx(2010.0 * kScale));
  CHECK(volts[3 * 3] == Approx(3014.0 * kScale));
  CHECK(data.noise_v[0] < 5.0 * kScale);
}

TEST_CASE("load_dataset: scans of a taxel that differ repeatedly count as noise, not as outliers") {
  AnalysedStore store;
  const std::int64_t run = begin(*store, {{0, "tiny", "r = 1", "", 1, 8}});
  const std::int64_t branch = store->begin_branch(run, {0, 0, 0, 0, 0, false, "", 0.0, 14.0});
  for (int i = 0; i < 8; ++i)
    store->append_frame(
        run, frame(branch, i, 2.0 * i, {static_cast<std::uint16_t>(i < 4 ? 5000 : 0), 7000, 10000, 7000}, 2, 1, 2));
  const Dataset data = load_dataset(*store, run);
  CHECK(data.outlying == 0);
  CHECK(data.noise_v[0] > 2000.0 * kScale);
  CHECK(data.noise_v[1] < kScale);
}

TEST_CASE("stored fit: is read back bit for bit and evaluates the same") {
  AnalysedStore store;
  Dataset source = run(Array({.rows = 3, .columns = 2}), {.repeats = 2});
  for (SequenceData& sequence : source.sequences)
    for (Repeat& repeat : sequence.repeats)
      for (std::size_t i = 0; i < repeat.steps.size(); ++i) repeat.volts[i * 6 + 4] = 0.0;  // a dead one
  const std::int64_t number = record_dataset(*store, source);
  const Dataset data = load_dataset(*store, number);
  const SensorModel fit = fit_array(data, fit_by("elam", {.exact_outer = true}));
  CHECK_THROWS_AS(load_fit(*store, number), AnalysisError);
  const std::int64_t kept = store_fit(*store, fit, "0.1.0", "2024-01-01T00:00:00Z");
  CHECK(kept > 0);
  const SensorModel back = load_fit(store->fit(kept));

  CHECK(back.run == number);
  CHECK(back.sensor_serial == "S1");
  CHECK(back.scanner_serial == "C1");
  CHECK(back.origin == "simulated");
  CHECK(back.full_scale_v() == fit.full_scale_v());
  CHECK(back.pressure_psi == fit.pressure_psi);
  const auto same = [](const ModelTaxel& a, const ModelTaxel& b) {
    CHECK(a.status == b.status);
    CHECK(a.noise == b.noise);
    CHECK(a.fit.j == b.fit.j);
    CHECK(a.fit.mean_error == b.fit.mean_error);
    CHECK(a.fit.max_error == b.fit.max_error);
    CHECK(a.full_scale() == b.full_scale());
    CHECK(a.fit.at_bound == b.fit.at_bound);
    REQUIRE((elam_of(a) == nullptr) == (elam_of(b) == nullptr));
    if (elam_of(a) == nullptr) return;
    const ElamParameters &p = elam_of(a)->parameters, &q = elam_of(b)->parameters;
    CHECK((p.alpha_d == q.alpha_d && p.beta_d == q.beta_d && p.beta_a == q.beta_a));
    CHECK((p.alpha_a1 == q.alpha_a1 && p.alpha_a0 == q.alpha_a0));
    CHECK(std::ranges::equal(a.ascending.y(), b.ascending.y()));
    CHECK(std::ranges::equal(a.descending.y(), b.descending.y()));
  };
  REQUIRE(back.array().size() == 6);
  for (std::size_t i = 0; i < 6; ++i) same(fit.taxels[i], back.taxels[i]);
  same(fit.mean_taxel(), back.mean_taxel());
  CHECK(back.taxels[4].status == TaxelStatus::kDead);
  CHECK(elam_of(back.taxels[0])->options.exact_outer);
  CHECK(evaluate(data, back).mean_error_psi == evaluate(data, fit).mean_error_psi);
}
