#include "bench/benchmarks/page.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <stdexcept>

#include "analysis/statistics/numbers/moments.h"
#include "bench/benchmarks/page_viewers.h"
#include "bench/common/utc.h"
#include "bench/run/characterize.h"

namespace tactbench::bench {

namespace {

using PageClock = std::chrono::steady_clock;

constexpr int kViewers = 8;
constexpr double kPace = 48.0;  // about 20 frames a second of one scan in 2.4 s

double passed_since(PageClock::time_point start) {
  return std::chrono::duration<double>(PageClock::now() - start).count();
}

double thread_s() {
  timespec time{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

struct RunBeside {
  PageRunTimes times;
  std::vector<PageClock::time_point> stored;  // when each frame was stored, or a little later
};

RunBeside run_beside(const std::string& db, int repeats, double pace) {
  db::RunStore store = db::RunStore::open(db, db::Durability::kNormal);
  RunRequest request;
  request.bench = read_bench(find_config("simulated.toml"), {}, {1, 1});
  request.recipes = {sequences::read_recipe(
      find_recipe("descending"),
      {{"repeats", std::to_string(repeats)}, {"conditioning.cycles", "0"}, {"conditioning.least", "0"}})};
  request.sensor_type = read_sensor_type(find_config("sensor.toml"));
  request.sensor = {"B-1",
                    request.sensor_type.name,
                    request.sensor_type.text,
                    db::sha256_hex(request.sensor_type.text),
                    "SIM-SCANNER-1",
                    "",
                    utc_now()};
  if (!store.sensor(request.sensor.serial)) store.add_sensor(request.sensor);
  request.operator_name = "benchmark";
  request.check_seating = false;
  request.pace = pace;
  RunBeside run;
  PageClock::time_point first{}, last{};
  double first_s = 0.0, last_s = 0.0;
  bool measured = false;
  request.on_step = [&](const sequences::Step& step) {
    last = PageClock::now();
    last_s = thread_s();
    if (first == PageClock::time_point{}) {
      first = last;
      first_s = last_s;
    }
    if (measured) run.stored.push_back(last);
    measured = sequences::takes_frame(step);
  };
  Progress quiet(Progress::Mode::kQuiet);
  const RunResult result = characterize(request, store, quiet);
  if (result.error) throw *result.error;
  run.times = {std::chrono::duration<double>(last - first).count(), last_s - first_s,
               static_cast<double>(result.frames_kept)};
  return run;
}

// Processor seconds to write these events to /dev/null, once for each viewer.
double bare_writes_s(const std::string& events) {
  const int null = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
  const double begun = thread_s();
  for (std::size_t at = 0; at < events.size();) {
    const std::size_t end = std::min(events.find("\n\n", at), events.size() - 2) + 2;
    for (int viewer = 0; viewer < kViewers; ++viewer) (void)!::write(null, events.data() + at, end - at);
    at = end;
  }
  const double took = thread_s() - begun;
  ::close(null);
  return took;
}

void measure_serving(FigureList& figures, const std::string& folder) {
  const std::string db = folder + "/served.db";
  (void)run_beside(db, 1, 0.0);  // so that there is an earlier run
  const PageProcess page(db, folder);
  PageViewers viewers(page, kViewers, 0);
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  const double before_s = page.processor_s();
  const auto begun = PageClock::now();
  const RunBeside run = run_beside(db, 1, kPace);
  PageServed served;
  served.took_s = passed_since(begun);
  served.frames = run.times.frames;
  served.page_s = page.processor_s() - before_s;
  served.delays_ms = delays_ms_of(viewers.pictures(), run.stored, begun);
  if (served.delays_ms.size() < 10) throw std::runtime_error("the viewers saw too little of the run");
  served.bare_writes_s = bare_writes_s(viewers.text());
  served.resident_mb = page.resident_mb();
  add_figures(figures, served);
}

void measure_run(FigureList& figures, int rounds, const std::string& folder) {
  constexpr int kPageRepeats = 10;
  std::vector<PageRunPair> pairs;
  for (int round = 0; round < rounds; ++round) {
    const RunBeside alone = run_beside(fmt::format("{}/alone-{}.db", folder, round), kPageRepeats, 0.0);
    const std::string db = fmt::format("{}/seen-{}.db", folder, round);
    (void)run_beside(db, 1, 0.0);
    const PageProcess page(db, folder);
    PageViewers viewers(page, kViewers, 1);
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    const auto begun = PageClock::now();
    const RunBeside seen = run_beside(db, kPageRepeats, 0.0);
    const auto& pictures = viewers.pictures();
    if (std::ranges::none_of(pictures, [&](const auto& picture) { return picture.second > begun; }))
      throw std::runtime_error("the viewers did not see the run");
    pairs.push_back({alone.times, seen.times});
  }
  add_figures(figures, pairs);
}

}  // namespace

std::vector<double> delays_ms_of(const std::map<std::int64_t, PageClock::time_point>& pictures,
                                 const std::vector<PageClock::time_point>& stored, PageClock::time_point begun) {
  std::vector<double> delays;
  for (const auto& [position, came] : pictures) {
    const auto index = static_cast<std::size_t>(position - 1);
    if (came > begun && position > 0 && index < stored.size())
      delays.push_back(std::chrono::duration<double, std::milli>(came - stored[index]).count());
  }
  return delays;
}

void add_figures(FigureList& figures, const PageServed& served) {
  figures.add("frames", served.frames / served.took_s, "1/s");
  figures.add("pictures", static_cast<double>(served.delays_ms.size()) / served.took_s, "1/s");
  figures.add_at_most("core", 100.0 * served.page_s / served.took_s, 1.0, "%");
  figures.add("core_bare_writes", 100.0 * served.bare_writes_s / served.took_s, "%");
  figures.add_at_most("resident", served.resident_mb, 20.0, "MB");
  figures.add("stored_to_viewer_median", analysis::quantile_of(served.delays_ms, 0.5), "ms");
  figures.add_at_most("stored_to_viewer_p95", analysis::quantile_of(served.delays_ms, 0.95), 150.0, "ms");
}

void add_figures(FigureList& figures, const std::vector<PageRunPair>& pairs) {
  std::vector<double> wall, processor;
  for (const auto& [alone, seen] : pairs) {
    wall.push_back(seen.wall_s / alone.wall_s);
    processor.push_back(seen.processor_s / alone.processor_s);
  }
  figures.add("step", 1e6 * pairs.back().alone.wall_s / pairs.back().alone.frames, "us");
  figures.add("step_with_viewers_wall", analysis::quantile_of(wall, 0.5), "x");
  figures.add_at_most("step_with_viewers", analysis::quantile_of(processor, 0.5), 1.02);
}

std::vector<Figure> benchmark_page(int rounds, const std::string& folder) {
  FigureList figures("page");
  measure_serving(figures, folder);
  measure_run(figures, rounds, folder);
  return figures.take();
}

}  // namespace tactbench::bench
