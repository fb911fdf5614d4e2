// The page of a live run: it is found by its bench and store, shown with each piece of news, takes commands and
// answers, and is let go when it hangs up.
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench/run/control/control_client.h"
#include "tests/bench/cli/verb_here.h"
#include "tests/bench/page/served_page.h"
#include "tests/support/answering_run.h"
#include "tests/support/endless_run.h"

using namespace tactbench;
using namespace tactbench::tests;
using nlohmann::json;

namespace {

// A page over a store whose run 1 has not ended.
class LivePage : public WordsPage {
 public:
  explicit LivePage(const std::string& bench = "page-words")
      : WordsPage([&](bench::PageOptions& own) {
          own.bench = bench;
          db::RunStore store = db::RunStore::open(own.db, db::Durability::kNormal);
          const Begun begun = begin_example(store);
          store.append_frame(begun.run, example_frame(begun.branch, 0));
        }),
        viewer(server->port()) {
    REQUIRE(viewer.send(head("GET /events", server->access().read_token)));
  }
  // The next event of that name whose data are so; null: none comes.
  template <class So>
  json event(const std::string& name, const So& so) {
    json found;
    const std::string mark = "event: " + name + "\ndata: ";
    (void)comes_true([&] {
      const std::string text = viewer.read(20, "never");
      for (std::size_t at = text.find(mark, from_); at != std::string::npos; at = text.find(mark, at + 1)) {
        const std::size_t from = at + mark.size(), end = text.find("\n\n", from);
        if (end == std::string::npos) return false;
        json data = json::parse(text.substr(from, end - from));
        if (!so(data)) continue;
        found = std::move(data);
        from_ = end;
        return true;
      }
      return false;
    });
    return found;
  }
  // The next state that is live or not, and is so.
  template <class So>
  json state(bool live, const So& so) {
    json found = event("state", [&](const json& data) { return data["live"] == live && so(data); });
    REQUIRE_FALSE(found.is_null());
    return found;
  }
  json live_state() {
    return state(true, [](const json&) { return true; });
  }
  json ended_state() {
    return state(false, [](const json& data) { return data.contains("next"); });
  }
  RawClient viewer;

 private:
  std::size_t from_ = 0;
};

}  // namespace

TEST_CASE("live page: shows the run of its bench and store with readings, state and end") {
  LivePage page;
  AnsweringRun run("page-words", 1, page.options.db);
  run.status.phase = "unloading";
  run.publish();
  run.control.see(bench::RunReadings{1.5, 20.0, 20.25, 20.5, true, std::nullopt});
  const json readings = page.event("readings", [](const json& data) { return data.contains("reference_psi"); });
  REQUIRE_FALSE(readings.is_null());
  CHECK(readings["run"] == 1);
  CHECK(readings["phase"] == "unloading");
  CHECK(readings["reference_psi"] == 20.5);
  const json state = page.live_state();
  CHECK(state["view"]["run"] == 1);
  CHECK(state["view"]["state"] == "running");
  CHECK(state["view"]["question_id"] == 0);
  CHECK(state["silent_s"].get<double>() >= 0.0);
  run.status.question = "Point indenter mounted?";
  run.status.question_id = 1;
  run.status.state = bench::RunState::kPaused;
  run.publish();
  const json asked = page.state(true, [](const json& data) { return data["view"]["question_id"] == 1; });
  CHECK(asked["view"]["question"] == "Point indenter mounted?");
  CHECK_FALSE(asked["view"].contains("answer"));
  CHECK(page.command({{"word", "answer"}, {"run", 1}, {"question", 1}, {"text", "with 2 Nm"}})["taken"] == true);
  const json answered = page.state(true, [](const json& data) { return data["view"].contains("answer"); });
  CHECK(answered["view"]["answer"]["question"] == 1);
  CHECK(answered["view"]["answer"]["text"] == "with 2 Nm");
  CHECK_THAT(answered["view"]["answer"]["who"].get<std::string>(), Catch::StartsWith("bob"));
  run.socket.reset();
  CHECK(page.ended_state()["silent_s"] == 0.0);
}

TEST_CASE("live page: each command goes only to the run that the operator saw, and its answer is returned") {
  LivePage page;
  AnsweringRun run("page-words", 1, page.options.db);
  (void)page.live_state();
  const auto say = [&](const char* word, std::int64_t number = 1) {
    return page.command({{"word", word}, {"run", number}});
  };
  CHECK(say("pause", 2)["taken"] == false);
  for (const json& no_number : json::array({1.5, "1", nullptr, true, 4294967297}))
    for (const char* member : {"run", "question"}) {
      json words = {{"word", "pause"}, {"run", 1}, {"question", 1}};
      words[member] = no_number;
      CHECK(status_of(page.send_command(words)->read()) == 400);
    }
  CHECK_FALSE(run.control.pause_wanted());
  CHECK(say("resume")["taken"] == false);
  CHECK(say("pause")["taken"] == true);
  CHECK(run.control.pause_wanted());
  CHECK(say("resume")["taken"] == true);
  CHECK(run.control.consume_resume());
  for (const char* word : {"stop", "abort", "panic"}) CHECK(say(word)["taken"] == true);
  CHECK_THAT(run.control.who(), Catch::StartsWith("bob"));
  CHECK(page.command({{"word", "answer"}, {"run", 1}, {"question", 3}, {"text", "x"}})["taken"] == false);
}

TEST_CASE("live page: leaves a bench with another store for one with this store") {
  LivePage page("");  // any bench
  AnsweringRun foreign("page-a", 7, page.folder.path("other.db"));
  AnsweringRun own("page-b", 1, page.options.db);
  const json state = page.live_state();
  CHECK(state["view"]["run"] == 1);
  CHECK(state["view"]["bench"] == "page-b");
  // One that is named through another folder is the same store.
  own.socket.reset();
  (void)page.ended_state();
  AnsweringRun linked("page-c", 1, page.folder.path("./x/../runs.db"));
  (void)page.state(true, [](const json& data) { return data["view"]["bench"] == "page-c"; });
}
