#include "bench/benchmarks/page.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <thread>

#include "analysis/statistics/numbers/moments.h"
#include "bench/benchmarks/page_viewers.h"
#include "bench/benchmarks/simulated_run.h"

namespace tactbench::bench {

namespace {

using PageClock = std::chrono::steady_clock;

struct RunBeside {
  PageRunTimes times;
  std::vector<PageClock::time_point> stored;  // when each frame was stored, or a little later
};

RunBeside run_beside(const std::string& db, int repeats, double pace) {
  struct Moment {
    double wall_s = 0.0, thread_s = 0.0;
  };
  db::RunStore store = db::RunStore::open(db, db::Durability::kNormal);
  RunRequest request = descending_request(repeats, 1);
  request.pace = pace;
  RunBeside run;
  std::optional<Moment> first;
  Moment last;
  bool measured = false;
  request.on_step = [&](const sequences::Step& step) {
    if (measured) run.stored.push_back(PageClock::now());
    last = {now_s(By::kWall), now_s(By::kThread)};
    if (!first) first = last;
    measured = sequences::takes_frame(step);
  };
  const RunResult result = carry_out(request, store);
  run.times = {last.wall_s - first.value().wall_s, last.thread_s - first.value().thread_s,
               static_cast<double>(result.frames_kept)};
  return run;
}

// Processor seconds to write these events to /dev/null, once for each viewer.
double bare_writes_s(const std::vector<std::string_view>& events, int viewers) {
  const int null = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
  const double taken = best_seconds(
      1,
      [&] {
        for (const std::string_view event : events)
          for (int viewer = 0; viewer < viewers; ++viewer) (void)!::write(null, event.data(), event.size());
      },
      By::kThread);
  ::close(null);
  return taken;
}

struct PageSubject {
  const std::string& folder;
  const PageSizes& sizes;
  const std::string& program;
};

void measure_serving(FigureList& figures, const PageSubject& subject) {
  const std::string db = subject.folder + "/served.db";
  (void)run_beside(db, 1, 0.0);  // so that there is an earlier run
  const PageProcess page(db, subject.folder, subject.program);
  PageViewers viewers(page.port(), page.token(), subject.sizes.viewers, 0);
  std::this_thread::sleep_for(subject.sizes.before_run);
  const double before_s = page.processor_s(), begun_s = now_s(By::kWall);
  const auto begun = PageClock::now();
  const RunBeside run = run_beside(db, 1, subject.sizes.pace);
  PageServed served;
  served.took_s = now_s(By::kWall) - begun_s;
  served.frames = run.times.frames;
  served.page_s = page.processor_s() - before_s;
  served.delays_ms = delays_ms_of(viewers.pictures(), run.stored, begun);
  if (served.delays_ms.size() < subject.sizes.least_pictures)
    throw std::runtime_error("the viewers saw too little of the run");
  served.bare_writes_s = bare_writes_s(events_of(viewers.text()), subject.sizes.viewers);
  served.resident_mb = page.resident_mb();
  add_figures(figures, served);
}

PageRunPair run_alone_and_seen(int round, const PageSubject& subject) {
  const auto db = [&](const char* name) { return fmt::format("{}/{}-{}.db", subject.folder, name, round); };
  const RunBeside alone = run_beside(db("alone"), subject.sizes.repeats, subject.sizes.pace_of_pair);
  (void)run_beside(db("seen"), 1, 0.0);
  const PageProcess page(db("seen"), subject.folder, subject.program);
  PageViewers viewers(page.port(), page.token(), subject.sizes.viewers, 1);
  std::this_thread::sleep_for(subject.sizes.before_run);
  const auto begun = PageClock::now();
  const RunBeside seen = run_beside(db("seen"), subject.sizes.repeats, subject.sizes.pace_of_pair);
  if (std::ranges::none_of(viewers.pictures(), [&](const auto& picture) { return picture.second > begun; }))
    throw std::runtime_error("the viewers did not see the run");
  return {alone.times, seen.times};
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

std::vector<std::string_view> events_of(std::string_view stream) {
  std::vector<std::string_view> events;
  while (!stream.empty()) {
    const std::size_t end = stream.find("\n\n");
    events.push_back(stream.substr(0, end == std::string_view::npos ? end : end + 2));
    stream.remove_prefix(events.back().size());
  }
  return events;
}

std::vector<Figure> benchmark_page(int rounds, const std::string& folder, const PageSizes& sizes,
                                   const std::string& program) {
  const PageSubject subject{folder, sizes, program};
  FigureList figures("page");
  measure_serving(figures, subject);
  std::vector<PageRunPair> pairs;
  for (int round = 0; round < rounds; ++round) pairs.push_back(run_alone_and_seen(round, subject));
  add_figures(figures, pairs);
  return figures.take();
}

}  // namespace tactbench::bench
