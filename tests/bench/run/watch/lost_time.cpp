// Lost time of a stored run, frame by frame: which interruptions are before a frame, and how much of the gap they are.
#include "bench/run/watch/watches.h"

#include <catch2/catch.hpp>

#include "db/run_store.h"
#include "tests/support/process.h"

using namespace tactbench;
using bench::LostTime;

namespace {

constexpr std::int64_t kSecond = 1'000'000'000;

// Frames and events of one run, told in their order; times in seconds.
class Diary {
 public:
  Diary() {
    store_.add_sensor({"S-1", "type", "", "", "", "", ""});
    db::RunRecord run;
    run.uuid = db::new_uuid();
    run.origin = "simulated";
    run.state = "prepared";
    run.sensor_serial = "S-1";
    for (int i = 0; i < 2; ++i) run.sequences.push_back({i, "r", "", "", 1, 99});
    run_ = store_.begin_run(run);
    state("prepared -> running: begin", 0.0);
  }
  Diary& frames(std::initializer_list<double> times, int sequence = 0, bool kept = true) {
    db::BranchRecord branch;
    branch.sequence = sequence;
    branch.ordinal = branches_++;
    const std::int64_t number = store_.begin_branch(run_, branch);
    for (const double time : times) {
      db::FrameRecord frame;
      frame.branch = number;
      frame.ordinal = ordinal_++;
      frame.time_ns = static_cast<std::int64_t>(time * 1e9);
      frame.rows = frame.columns = frame.scans = 1;
      frame.counts = {0};
      store_.append_frame(run_, frame);
    }
    if (!kept) store_.void_branch(number, "done again");
    return *this;
  }
  Diary& state(const std::string& detail, double time) { return event("state", detail, time); }
  Diary& pause(double from, double to) {
    state("running -> pausing: asked by Ctrl-C", from - 0.5);
    state("pausing -> paused: asked by Ctrl-C", from);
    return state("paused -> running: resumed", to);
  }
  Diary& path_to_branch(double time) { return event("way-back", "conditioned again", time); }
  [[nodiscard]] std::vector<std::pair<std::int64_t, std::int64_t>> lost() const {
    std::vector<std::pair<std::int64_t, std::int64_t>> told;
    for (const LostTime& one : bench::lost_times(store_, run_, store_.last_position(run_))) {
      told.emplace_back(one.position, one.ns / kSecond);
      CHECK(one.ns % kSecond == 0);
    }
    return told;
  }

 private:
  Diary& event(const std::string& kind, const std::string& detail, double time) {
    store_.append_event(run_, {static_cast<std::int64_t>(time * 1e9), kind, "", detail});
    return *this;
  }
  tests::TemporaryFolder folder_;
  db::RunStore store_ = db::RunStore::open(folder_.path("runs.db"), db::Durability::kNormal);
  std::int64_t run_ = 0;
  int branches_ = 0, ordinal_ = 0;
};

using Lost = std::vector<std::pair<std::int64_t, std::int64_t>>;

}  // namespace

TEST_CASE("lost time: a pause between two frames lasts from the end of work to its continuation") {
  CHECK(Diary().frames({10, 20, 30}).lost().empty());
  CHECK(Diary().frames({10, 20, 30}).pause(31, 91).frames({102, 110}).lost() == Lost{{4, 60}});
  CHECK(Diary().pause(2, 6).frames({10, 20}).lost() == Lost{{1, 4}});
  CHECK(Diary().frames({10, 20}).pause(20, 50).frames({60}).lost() == Lost{{3, 30}});  // from the frame's own time on
  CHECK(Diary().frames({10, 20}).pause(21, 50).lost().empty());                        // nothing came later
  CHECK(Diary().frames({10, 20}).pause(12, 15).lost() == Lost{{2, 3}});
  Diary open;
  open.frames({10}).state("pausing -> paused: x", 12).frames({20});
  CHECK(open.lost().empty());  // it never went on
}

TEST_CASE("lost time: pauses before the same frame add up, pauses before different frames are separate") {
  CHECK(Diary().frames({10}).pause(11, 14).pause(16, 21).frames({30, 40}).lost() == Lost{{2, 8}});
  CHECK(Diary().frames({10}).pause(11, 14).frames({20}).pause(21, 26).frames({30}).lost() == Lost{{2, 3}, {3, 5}});
}

TEST_CASE("lost time: after a return path within a sequence the frame intervals still count, two at most") {
  const auto after = [](std::initializer_list<double> frames) {
    return Diary().frames({10, 20, 30}).pause(31, 91).path_to_branch(92).frames(frames).lost();
  };
  CHECK(after({150, 158, 165}) == Lost{{4, 120 - 7}});
  CHECK(after({150, 158, 167}) == Lost{{4, 120 - 8}});
  CHECK(after({150, 158, 167, 168}) == Lost{{4, 120 - 8}});
  CHECK(after({150, 158}) == Lost{{4, 120 - 8}});
  CHECK(after({150, 450}) == Lost{{4, 0}});  // no less than nothing
  CHECK(after({150}) == Lost{{4, 61}});      // no pace: from the frame before until it goes on
  // A way back of before the pause is none of it.
  CHECK(Diary().frames({10, 20}).path_to_branch(25).pause(31, 91).frames({150, 158}).lost() == Lost{{3, 60}});
  // One that begins after the frame neither.
  CHECK(Diary().frames({10, 20}).pause(31, 91).frames({150}).path_to_branch(155).frames({160}).lost() == Lost{{3, 60}});
  // The first of two counts.
  CHECK(Diary()
            .frames({10, 20, 30})
            .pause(31, 91)
            .path_to_branch(92)
            .frames({150, 158, 165})
            .path_to_branch(170)
            .lost() == Lost{{4, 113}});
}

TEST_CASE("lost time: a return path into another sequence is not lost, work begun before the pause is") {
  CHECK(Diary().frames({10, 20}).pause(31, 91).path_to_branch(92).frames({150, 158}, 1).lost() == Lost{{3, 71}});
  CHECK(Diary().frames({10, 20}).pause(31, 91).frames({150, 158}, 1).lost() == Lost{{3, 60}});
  // The pace ends where the sequence does.
  CHECK(Diary().frames({10, 20}).pause(31, 91).path_to_branch(92).frames({150}).frames({158}, 1).lost() ==
        Lost{{3, 71}});
}

TEST_CASE("lost time: in a stopped and resumed run it starts at the last valid frame") {
  const auto resumed = [](const std::string& between) {
    Diary diary;
    diary.frames({10, 20}).frames({25, 28}, 0, false).state("running -> stopping: " + between, 30);
    diary.state("stopping -> ended: " + between, 31).state("ended -> prepared: resumed", 100);
    return diary.state("prepared -> running: again", 110).frames({140, 150}).lost();
  };
  CHECK(resumed("stopped") == Lost{{5, 90}});
  // Void frames are none, on either side.
  Diary both;
  both.frames({10, 20}).pause(31, 91).frames({95, 99}, 0, false).path_to_branch(101).frames({150, 158});
  CHECK(both.lost() == Lost{{5, 130 - 8}});
  Diary suspended;
  suspended.frames({10}).state("running -> suspended: supply", 15).state("suspended -> running: back", 40).frames({50});
  CHECK(suspended.lost() == Lost{{2, 25}});
  Diary odd;
  odd.frames({10}).state("no change of state", 12).state("running -> paused", 13).state("paused -> running", 17);
  CHECK(odd.frames({20}).lost() == Lost{{2, 4}});
}
