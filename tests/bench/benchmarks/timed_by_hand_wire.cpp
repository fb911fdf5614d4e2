// Whole benchmarks that need the simulated rig or several threads, on few frames and taxels, by a clock that says how
// long everything took. Each expected time is worked out from the acts' order (counted_time.h).
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "analysis/identify/elam/genetic.h"
#include "analysis/identify/elam/lanes.h"
#include "bench/benchmarks/array.h"
#include "bench/benchmarks/identify.h"
#include "bench/benchmarks/report.h"
#include "bench/benchmarks/sequence.h"
#include "db/run_store.h"
#include "tests/bench/benchmarks/counted_time.h"
#include "tests/bench/benchmarks/short_runs.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::bench;
using tests::ActsInOrder;
using tests::CountedTime;

namespace {

double figure_named(const std::vector<Figure>& figures, const std::string& name) {
  for (const Figure& figure : figures)
    if (figure.name == name) return figure.value;
  FAIL("no figure " << name);
  return 0.0;
}

}  // namespace

TEST_CASE("benchmark array: three forms of an array stretch by stretch, then the median of its scans") {
  const std::vector<Figure> figures = [] {
    const CountedTime time;
    return benchmark_array(2, {101, 5});
  }();
  ActsInOrder act;
  const double plain = act.sum_of(2);
  act.pass(2);
  const double specimen = act.sum_of(2);
  act.pass(2);
  const double counts = act.sum_of(2);
  act.pass(2);
  const double wire = 1e6 * act.median_of(5), frame = 1e6 / 101;
  REQUIRE(figures.size() == 6);
  CHECK(figure_named(figures, "array_plain_plays") == Approx(frame * plain));
  CHECK(figure_named(figures, "array_specimen_moved_and_read") == Approx(frame * specimen));
  CHECK(figure_named(figures, "array_specimen_over_plain_plays") == Approx(specimen / plain));
  CHECK(figure_named(figures, "array_counts_with_noise") == Approx(frame * counts));
  CHECK(figure_named(figures, "array_frame_on_the_wire") == Approx(wire));
  CHECK(figure_named(figures, "array_share_of_the_wire") == Approx(frame * counts / wire));
}

TEST_CASE("benchmark report: one page, written alone and rendered and written, by processor time") {
  const tests::TemporaryFolder folder;
  std::vector<By> readings;
  const std::vector<Figure> figures = [&] {
    const CountedTime time;
    std::vector<Figure> found = benchmark_report(2, folder.path(), {2, 1});
    readings = time.readings();
    return found;
  }();
  const std::string page = tests::read_file(folder.path("report.html"));
  CHECK(page == tests::read_file(folder.path("floor.html")));
  CHECK(page.size() > 10000);
  CHECK(figure_named(figures, "report_size") == Approx(static_cast<double>(page.size()) / 1e6).epsilon(1e-9));
  CHECK(figure_named(figures, "report_write_alone") == Approx(2000.0));
  CHECK(figure_named(figures, "report_rendered_and_written") == Approx(4000.0));
  CHECK(figure_named(figures, "report_over_write_alone") == Approx(2.0));
  CHECK(figures.size() == 6);
  CHECK(readings == std::vector<By>(8, By::kProcessor));
  const db::RunStore store = db::RunStore::open_read_only(folder.path("report.db"));
  CHECK(store.frame_count(1) == 211 + 451);
  CHECK((store.frames(1).front().rows == 2 && store.frames(1).front().columns == 2));
}

TEST_CASE("benchmark identify: what is timed, in which order, and the runs that the dynamic model is fitted on") {
  const tests::TemporaryFolder folder;
  tests::ShortRuns runs(2);
  const std::vector<Figure> figures = [&] {
    const CountedTime time;
    IdentifySizes sizes;
    sizes.side = 2;
    sizes.repeats = 1;
    sizes.few = 1;
    sizes.growth = {1, 2};
    return benchmark_identify(2, folder.path(), sizes, runs.in_place());
  }();
  const auto figure = [&](const std::string& name) { return figure_named(figures, "identify_" + name); };
  ActsInOrder act;
  const double plain_j = act.next();
  CHECK(figure("plain_j") == Approx(1e6 * plain_j / 4));
  for (const analysis::Dispatch level : analysis::dispatches()) {
    const double own = act.next();
    CHECK(figure(std::string("elam_") + to_string(level)) == Approx(1e6 * own / 4));
    CHECK(figure(std::string("elam_") + to_string(level) + "_in_plain_j") == Approx(own / plain_j));
  }
  act.pass(1 + static_cast<int>(analysis::dispatches().size()));
  if (analysis::has_genetic()) {  // one round, of the few
    const double exact = act.next(), genetic = act.next();
    CHECK(figure("elam_genetic") == Approx(1e6 * genetic));
    CHECK(figure("elam_genetic_time_over_exact") == Approx(genetic / exact));
    CHECK(figure("elam_genetic_j_over_exact") > 0.99);  // the exact search finds the least J
    CHECK(figure("elam_genetic_j_over_exact") < 100.0);
    CHECK(figure("elam_genetic_j_over_exact_worst_taxel") == Approx(figure("elam_genetic_j_over_exact")));
  }
  const double reading = act.next(), alone = act.next(), from_store = act.next();
  act.pass(3);
  CHECK(figure("array_reading") == Approx(1e3 * reading));
  CHECK(figure("array_identification_alone") == Approx(1e3 * alone));
  CHECK(figure("array_from_store") == Approx(1e3 * from_store));
  CHECK(figure("array_over_floor") == Approx(from_store / (reading + alone)));
  const double one_thread = act.next();
  act.pass(1);
  const double two_threads = act.next();
  act.pass(1);
  CHECK(figure("two_threads_speedup") == Approx(one_thread / two_threads));
  const double smallest = 1e6 * act.next();
  act.pass(1);
  const double largest = 1e6 * act.next() / 4;
  act.pass(1);
  CHECK(figure("growth_1x1") == Approx(smallest));
  CHECK(figure("growth_2x2") == Approx(largest));
  CHECK(figure("growth_2x2_over_1x1") == Approx(largest / smallest));
  for (const std::string model : {"gpi", "mpi", "poly", "preisach"}) {
    const double fit = act.next(), walk = act.next();
    act.pass(2);
    CHECK(figure(model) == Approx(1e6 * fit));
    CHECK(figure(model + "_in_walks") == Approx(fit / walk));
  }
  CHECK(figure("dynamic_array") == Approx(act.next()));
  CHECK(runs.asked == std::vector<std::string>{"dynamic.db paper 1 1: descending ascending",
                                               "dynamic.db paper 1 2: rate", "dynamic.db paper 1 3: creep-levels"});
  const db::RunStore stored = db::RunStore::open_read_only(folder.path("identify.db"));
  CHECK(stored.frame_count(1) == 211 + 451);
  CHECK(db::RunStore::open_read_only(folder.path("dynamic.db")).runs().size() == 3);
}

TEST_CASE("benchmark sequence: the run from its first step to its last, then its exchanges and its frames alone") {
  const tests::TemporaryFolder folder;
  std::size_t readings = 0;
  const std::vector<Figure> figures = [&] {
    const CountedTime time;
    std::vector<Figure> found = benchmark_sequence(2, folder.path());
    readings = time.readings().size();
    return found;
  }();
  // In each round a reading a step, of which there are 211, then one at the begin and the end of either part.
  CHECK(readings == 2 * (211 + 4));
  CHECK(figure_named(figures, "sequence_steps") == 210.0);
  double run_s = 0.0;
  for (int n = 2; n <= 211; ++n) run_s += n;
  const double step = 1e6 / 210;
  CHECK(figure_named(figures, "sequence_run") == Approx(step * run_s).epsilon(1e-9));
  CHECK(figure_named(figures, "sequence_bare_exchanges") == Approx(step * 213).epsilon(1e-9));
  CHECK(figure_named(figures, "sequence_bare_store") == Approx(step * 215).epsilon(1e-9));
  CHECK(figure_named(figures, "sequence_ratio") == Approx(run_s / (213 + 215)).epsilon(1e-9));
  for (const std::string round : {"1", "2"}) {
    const db::RunStore run = db::RunStore::open_read_only(folder.path("run-" + round + ".db"));
    const db::RunStore bare = db::RunStore::open_read_only(folder.path("bare-" + round + ".db"));
    CHECK(run.run(1).seed == std::stoi(round));
    CHECK(run.run(1).outcome == db::Outcome::kCompleted);
    CHECK(bare.run(1).sensor_serial == run.run(1).sensor_serial);
    CHECK(bare.run(1).sequences.front().repeats == 1);
    CHECK(bare.run(1).sequences.front().frames_per_repeat == 210);
    CHECK(bare.run(1).sequences.front().sequence == 0);
    const std::vector<db::FrameRecord> frames = run.frames(1), again = bare.frames(1);
    REQUIRE(frames.size() == 211);  // no conditioning: from 0 psi
    REQUIRE(again.size() == 210);
    for (std::size_t i = 0; i < again.size(); ++i) {
      CHECK(again[i].time_ns == frames[i].time_ns);
      CHECK(again[i].counts == frames[i].counts);
      CHECK(again[i].trace.size() == frames[i].trace.size());
    }
  }
}
