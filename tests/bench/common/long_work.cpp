// The progress line of verbs that compute: what it says at each moment, and where it keeps silent.
#include "bench/common/long_work.h"

#include <catch2/catch.hpp>

#include "analysis/work_count.h"

using namespace tactbench;
using namespace tactbench::bench;

TEST_CASE("where nothing counts a stage, its part follows from its share and the pace before it") {
  const std::vector<WorkStage> stages = {{"models", 4.0}, {"uncertainty", 2.0, false}};
  CHECK(guessed_part(stages, 1, 8.0, 1.0) == Approx(0.25));  // it should take 4 s
  CHECK(guessed_part(stages, 1, 8.0, 3.0) == Approx(0.75));
  CHECK(guessed_part(stages, 1, 8.0, 300.0) == Approx(0.95));  // late, but not done
  CHECK(guessed_part(stages, 0, 0.0, 300.0) == 0.0);           // nothing came before
}

TEST_CASE("work counts its pieces, and work within it is part of a piece") {
  const std::size_t before = analysis::work_now().works;
  {
    analysis::Work outer(10);
    outer.add(3);
    {
      analysis::Work inner(99);
      inner.add(50);
      CHECK(analysis::work_now().count == 10);
      CHECK(analysis::work_now().done == 3);
    }
    outer.add();
    CHECK(analysis::work_now().done == 4);
    CHECK(analysis::work_now().works == before + 1);
  }
  CHECK(analysis::work_now().count == 0);
  analysis::Work next(2);
  CHECK(analysis::work_now().done == 0);
  CHECK(analysis::work_now().works == before + 2);
}

TEST_CASE("where no verb computes a stage begins, and progress pauses, without effect") {
  CHECK_NOTHROW(begin_stage("reading"));
  CHECK_NOTHROW(pause_progress());
}

TEST_CASE("without a terminal there is no progress line and no thread that watches") {
  LongWork work("fit", false, {{"reading", 1.0}});  // a test has no terminal
  CHECK_FALSE(work.shows());
  work.begin("reading");
  work.end();
}
