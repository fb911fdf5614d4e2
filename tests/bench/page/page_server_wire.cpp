// Answers of the page's server: the first events of a viewer, each path with data of the store, documents, and links.

#include <poll.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "analysis/identify/sensor_model.h"
#include "analysis/identify/stored/model_document.h"
#include "bench/page/access.h"
#include "bench/page/frames.h"
#include "bench/reporting/evaluation.h"
#include "bench/run/control/control_client.h"
#include "bench/run/control/locks.h"
#include "tests/bench/cli/verb_here.h"
#include "tests/bench/page/served_page.h"
#include "tests/bench/reporting/film_runs.h"
#include "tests/support/answering_run.h"
#include "tests/support/endless_run.h"

using namespace tactbench;
using namespace tactbench::tests;
using nlohmann::json;

namespace {

// The data of that event, the n-th of its name.
json event_in(const std::string& text, const std::string& name, std::size_t number = 0) {
  const std::string mark = "event: " + name + "\ndata: ";
  std::size_t at = text.find(mark);
  for (std::size_t i = 0; i < number && at != std::string::npos; ++i) at = text.find(mark, at + 1);
  if (at == std::string::npos) return {};
  const std::size_t from = at + mark.size();
  return json::parse(text.substr(from, text.find("\n\n", from) - from));
}

std::size_t events_in_text(const std::string& text, const std::string& mark) {
  std::size_t count = 0;
  for (std::size_t at = text.find(mark); at != std::string::npos; at = text.find(mark, at + 1)) ++count;
  return count;
}

void store_page_run(const std::string& path) {
  db::RunStore store = db::RunStore::open(path, db::Durability::kNormal);
  (void)store_example(store);
}

}  // namespace

TEST_CASE("page server: a viewer gets its rights, the state and the picture at once, and the state each second") {
  WordsPage page([](bench::PageOptions& options) { store_page_run(options.db); });
  REQUIRE(comes_true([&] {  // it has looked into the store
    RawClient looks(page.server->port());
    (void)looks.send(page.head("GET /events", page.server->access().read_token));
    return looks.read(100, "event: picture").find("event: picture") != std::string::npos;
  }));
  RawClient reader(page.server->port()), commander(page.server->port());
  REQUIRE(reader.send(page.head("GET /events", page.server->access().read_token)));
  REQUIRE(commander.send(page.head("GET /events", page.server->access().command_token)));
  const std::string first = reader.read(20'000, "event: picture");
  CHECK(event_in(first, "hello") == json({{"operator", ""}, {"commands", true}, {"night", false}}));
  CHECK(event_in(first, "state")["live"] == false);
  CHECK(event_in(first, "state")["view"]["run"] == 1);
  CHECK(event_in(reader.read(20'000, "\n\nevent: state"), "picture")["run"] == 1);
  CHECK(event_in(commander.read(20'000, "event: state"), "hello")["operator"] == "bob");
  const auto begun = std::chrono::steady_clock::now();
  CHECK(comes_true([&] { return events_in_text(reader.read(50, "never"), "event: state") >= 4; }));
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  CHECK(seconds > 1.5);  // nothing is new: three more at a second each, the first of them at any time
  WordsPage without([](bench::PageOptions& options) {
    options.operator_name.clear();
    options.night = "night.html";
  });
  RawClient other(without.server->port());
  REQUIRE(other.send(without.head("GET /events", without.server->access().read_token)));
  const std::string hello = other.read(20'000, "event: state");
  CHECK(event_in(hello, "hello") == json({{"operator", ""}, {"commands", false}, {"night", true}}));
  CHECK(hello.find("event: picture") == std::string::npos);
}

TEST_CASE("page server: paths that read the store answer 503 without a store") {
  WordsPage page;
  for (const char* path : {"/runs", "/sensors", "/loop?run=1", "/make/report?run=1"})
    CHECK(page.data_of(path, 503).contains("error"));
  store_page_run(page.options.db);
  CHECK(page.data_of("/runs")["runs"][0]["run"] == 1);
  CHECK(page.data_of("/sensors")["sensors"][0]["serial"] == "S-1");
  const json loop = page.data_of("/loop?run=1");
  CHECK(loop["taxel"] == -1);
  CHECK(loop["last"] == 3);
  CHECK(loop["x"].size() == 2);  // without the void branch
  const json whole = page.data_of("/loop?run=1&taxel=4"), rest = page.data_of("/loop?run=1&taxel=4&after=2");
  CHECK(rest["last"] == 3);
  CHECK((rest["x"] == json::array({whole["x"].back()}) && rest["y"] == json::array({whole["y"].back()})));
  CHECK_THAT(page.data_of("/loop?run=9", 500)["error"].get<std::string>(), Catch::Contains("9"));
}

TEST_CASE("page server: documents that cannot be made are errors, a nightly page is kept") {
  WordsPage page([](bench::PageOptions& options) { store_page_run(options.db); });
  for (const char* none : {"/make/sensor", "/make/sensor?serial=S-9", "/make/night"})
    CHECK(page.data_of(none, 404).contains("error"));
  for (const auto& [path, run] : {std::pair("/make/report?run=9", "9"),
                                  {"/make/report", "0"},
                                  {"/make/compare?run=1&with=8", "8"},
                                  {"/make/compare?run=7&with=1", "7"}})
    CHECK_THAT(page.data_of(path, 500)["error"].get<std::string>(), Catch::Contains(run));
  CHECK(status_of(page.get("/document/0123")) == 404);
  CHECK(status_of(page.get("/nowhere")) == 404);
  WordsPage night([](bench::PageOptions& options) {
    store_page_run(options.db);
    options.night = options.db + ".html";
    write_file(options.night, "<p>night</p>");
  });
  const std::string path = night.data_of("/make/night")["path"];
  CHECK_THAT(path, Catch::StartsWith("/document/"));
  const std::string document = night.get(path);
  CHECK(body_of(document) == "<p>night</p>");
  CHECK_THAT(document, Catch::Contains("\r\nContent-Type: text/html; charset=utf-8\r\n") &&
                           Catch::Contains("sandbox allow-popups"));
}

TEST_CASE("page server: links contain the tokens, and its own names are accepted as hosts") {
  WordsPage page([](bench::PageOptions& options) { options.names = {"rig"}; });
  const bench::PageAccess& access = page.server->access();
  const std::string place = fmt::format("http://127.0.0.1:{}/#{}", page.server->port(), access.read_token);
  CHECK(page.server->readers_link() == place);
  CHECK(page.server->link() == place + "." + access.command_token);
  const auto asks = [](const WordsPage& of, const std::string& host) {
    RawClient client(of.server->port());
    (void)client.send(
        fmt::format("GET / HTTP/1.1\r\nHost: {}:{}\r\nConnection: close\r\n\r\n", host, of.server->port()));
    return status_of(client.read());
  };
  for (const char* name : {"127.0.0.1", "localhost", "[::1]", "rig", "RIG"}) CHECK(asks(page, name) == 200);
  CHECK(asks(page, "other") == 421);
  const WordsPage everywhere([](bench::PageOptions& options) {
    options.http.address = "0.0.0.0";
    options.operator_name.clear();
  });
  CHECK(everywhere.server->access().command_token.empty());
  std::vector<std::string> addresses = bench::own_addresses(false), places;
  addresses.insert(addresses.begin(), "127.0.0.1");
  for (const std::string& address : addresses) {
    CHECK(asks(everywhere, address) == 200);
    places.push_back(
        fmt::format("http://{}:{}/#{}", address, everywhere.server->port(), everywhere.server->access().read_token));
  }
  CHECK(everywhere.server->links() == places);
  CHECK(asks(everywhere, "192.0.2.200") == 421);  // of documents, no machine's
}

TEST_CASE("page server: ends on request, or after the process next to it has ended and nobody is viewing") {
  bench::PageOptions options;
  bench::PageServer server(options);
  int asked = 0;
  server.serve([&] { return ++asked == 2; });
  CHECK(asked == 2);
  const pid_t ended = ::fork();
  if (ended == 0) ::_exit(0);
  ::waitpid(ended, nullptr, 0);
  options.run_process = ended;
  bench::PageServer beside(options);
  asked = 0;
  beside.serve([&] {
    ++asked;
    return asked > 100;
  });
  CHECK(asked == 1);
  options.run_process = ::getpid();
  bench::PageServer lives(options);
  asked = 0;
  lives.serve([&] { return ++asked == 3; });
  CHECK(asked == 3);
}

TEST_CASE("page server: a command without a live run is refused, and logged with the sender") {
  Captured noted(stderr);
  WordsPage page([](bench::PageOptions& options) { store_page_run(options.db); });
  const json answer = page.command({{"word", "pause"}, {"run", 1}});
  page.stop();
  CHECK(answer["taken"] == false);
  CHECK_THAT(noted.text(), Catch::StartsWith("bob") && Catch::Contains("{\"run\":1,\"word\":\"pause\"}"));
}

// The page of a live run: it is found by its bench and store, shown with each piece of news, takes commands and
// answers, and is let go when it hangs up.

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

// Pressures on the page: which earlier run's models a run is shown through, and what they make of its frames and of the
// time between them. On runs of two taxels that are stored by hand. Not a unit test: arrays are identified by several
// threads.

namespace {

FilmRun two_taxels() {
  FilmRun made;
  made.columns = 2;
  made.levels = {0.0,  10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 50.0, 40.0, 30.0, 20.0,
                 30.0, 40.0, 50.0, 60.0, 50.0, 40.0, 30.0, 20.0, 10.0, 0.0};
  return made;
}

class ModelledPage : public FilmStore {
 public:
  std::int64_t add_fitted(const FilmRun& made) {
    const std::int64_t run = add(made);
    analysis::Runs runs(store);
    (void)bench::fit_run(store, runs.dataset(run));
    return run;
  }
  [[nodiscard]] std::string words(std::int64_t run) const {
    const auto found = bench::CompensatedRun::of(store, store.run(run));
    return found ? found->model_text() : "none";
  }
  // A run under way, of the sensor.
  std::int64_t begin() {
    db::RunRecord run;
    run.uuid = db::new_uuid();
    run.origin = "simulated";
    run.state = "prepared";
    run.sensor_serial = "S-1";
    run.sequences = {{0, "a", "", "", 1, 100}};
    run.devices = store.run(1).devices;
    const std::int64_t number = store.begin_run(run);
    branch_ = store.begin_branch(number, {});
    return number;
  }
  void append(std::int64_t run, double volts, double seconds) {
    db::FrameRecord frame;
    frame.branch = branch_;
    frame.ordinal = frames_++;
    frame.rows = frame.scans = 1;
    frame.columns = 2;
    frame.time_ns = now_ns_ += static_cast<std::int64_t>(1e9 * seconds);
    frame.counts.assign(2, static_cast<std::uint16_t>(std::lround(1e4 * volts)));
    store.append_frame(run, frame);
  }

 private:
  std::int64_t branch_ = 0, now_ns_ = 0;
  int frames_ = 0;
};

}  // namespace

TEST_CASE("page models: of earlier valid runs with streaming models, the newest of the same sensor and origin") {
  ModelledPage made;
  FilmRun other = two_taxels(), hardware = two_taxels();
  other.sensor = "S-2";
  hardware.origin = "hardware";
  CHECK(made.add_fitted(two_taxels()) == 1);
  CHECK(made.add_fitted(two_taxels()) == 2);
  CHECK(made.add_fitted(two_taxels()) == 3);
  CHECK(made.add(two_taxels()) == 4);  // without models
  (void)made.add_fitted(other);
  (void)made.add_fitted(hardware);
  CHECK(made.add(two_taxels()) == 7);
  (void)made.add_fitted(two_taxels());  // later
  CHECK(made.words(7) == "elam of run 3");
  CHECK(made.words(3) == "elam of run 2");
  CHECK(made.words(1) == "none");
  CHECK(made.words(5) == "none");
  CHECK(made.words(6) == "none");
  made.store.void_run(3, "by hand", "me", "2026-03-02T00:00:00Z");
  CHECK(made.words(7) == "elam of run 2");
  // A fit of only the mean does not represent its run.
  analysis::FitOptions mean;
  mean.mean_alone = true;
  mean.model = "monotone";
  analysis::Runs runs(made.store);
  (void)bench::keep_fit(made.store, analysis::fit_array(runs.dataset(2), mean));
  CHECK(made.words(7) == "elam of run 2");
}

TEST_CASE("page models: give pressures of the newest frame, leave out a spike, and are looked up once") {
  ModelledPage made;
  (void)made.add_fitted(two_taxels());
  const std::int64_t run = made.begin();
  bench::RunFrames frames(made.store, made.store.run(run));
  CHECK_FALSE(frames.advance());
  for (const double psi : {0.0, 10.0, 20.0, 30.0}) made.append(run, film_volts(psi, true), 2.0);
  CHECK(frames.advance());
  const nlohmann::json picture = frames.picture();
  CHECK(picture["model"] == "elam of run 1");
  const std::vector<double> loaded = picture["psi"];
  CHECK(std::abs(loaded[0] - 30.0) < 1.0);
  CHECK(loaded[1] == loaded[0]);
  made.append(run, 6.0, 2.0);  // a spike, until it has stayed
  CHECK(frames.advance());
  CHECK(frames.picture()["psi"] == loaded);
  for (int i = 0; i < 3; ++i) made.append(run, 6.0, 2.0);
  CHECK(frames.advance());
  CHECK(frames.picture()["psi"] == std::vector<double>{60.0, 60.0});
  // A page that began before there were models goes on without.
  ModelledPage late;
  (void)late.add(two_taxels());
  const std::int64_t early = late.begin();
  bench::RunFrames without(late.store, late.store.run(early));
  CHECK_FALSE(without.advance());
  analysis::Runs runs(late.store);
  (void)bench::fit_run(late.store, runs.dataset(1));
  late.append(early, 1.0, 2.0);
  CHECK(without.advance());
  CHECK_FALSE(without.picture().contains("psi"));
}

TEST_CASE("page models: a model with creep gets the time between two frames, if there is one") {
  ModelledPage made;
  FilmRun run = two_taxels();
  (void)made.add(run);
  (void)made.add(run);
  analysis::Runs runs(made.store);
  analysis::SensorModel dynamic = bench::fit_run_dynamic(made.store, runs, 1);
  dynamic.dynamics->shared.creep_share = {0.02, 0.03, 0.04};
  (void)bench::keep_fit(made.store, dynamic);
  const analysis::SensorModel kept = analysis::load_fit(made.store, 1);
  struct Step {
    double volts, time_s;
    double stream_s;  // what the stream is to be told
  };
  const double day = 86'400.0;
  const std::vector<Step> steps = {{0.2, 100.0, 0.0},
                                   {1.0, 103.0, 3.0},
                                   {1.5, 104.0, 1.0},
                                   {1.5, 104.0, 0.0},
                                   {1.6, 103.0, 0.0},
                                   {1.6, 103.0 + day, day},
                                   {1.7, 102.0 + 2.0 * day, day - 1.0},
                                   {1.7, 1102.0 + 2.0 * day, 1000.0}};
  const auto shown = bench::CompensatedRun::of(made.store, made.store.run(2));
  REQUIRE(shown);
  analysis::FrameCompensator stream = analysis::frames_of(kept);
  std::vector<float> pressure(2), uncertainty(2);
  std::vector<std::uint16_t> status(2);
  for (const Step& step : steps) {
    db::StoredFrame frame;
    frame.time_ns = static_cast<std::int64_t>(1e9 * step.time_s);
    shown->see(frame, {1.0, 2.0, 3.0});  // of another array: left out, its time, too
    shown->see(frame, {step.volts, step.volts});
    const auto volts = static_cast<float>(step.volts);
    stream.frame(std::vector<float>{volts, volts}, step.stream_s, {pressure, uncertainty, status});
    INFO(step.time_s);
    CHECK(shown->pressure_psi()[0] == Approx(pressure[0]).epsilon(1e-6));
    CHECK(shown->pressure_psi()[1] == Approx(pressure[1]).epsilon(1e-6));
    CHECK(shown->status() == status);
  }
}

// Commands on the page to a run that sends its state but answers no command: how many wait, and the answer to each when
// it hangs up or stays silent. The run is a socket of the test's own.

namespace {

// Listens where a bench's run would.
class SocketRun {
 public:
  explicit SocketRun(const std::string& bench) : name_(bench) {}
  ~SocketRun() {
    for (const auto& [words, descriptor] : clients_) ::close(descriptor);
  }
  SocketRun(const SocketRun&) = delete;
  SocketRun& operator=(const SocketRun&) = delete;
  // The next client's first words; it stays connected. Empty: none comes in time.
  std::string accept() {
    pollfd ready{name_.descriptor(), POLLIN, 0};
    if (::poll(&ready, 1, 20'000) != 1) return {};
    const int descriptor = ::accept(name_.descriptor(), nullptr, nullptr);
    pollfd said{descriptor, POLLIN, 0};
    std::array<char, 4096> bytes{};
    const ssize_t size = ::poll(&said, 1, 20'000) == 1 ? ::recv(descriptor, bytes.data(), bytes.size(), 0) : 0;
    clients_.emplace_back(std::string(bytes.data(), static_cast<std::size_t>(std::max<ssize_t>(size, 0))), descriptor);
    return clients_.back().first;
  }
  void tell(std::size_t client, const json& words) const {
    const std::string text = words.dump();
    REQUIRE(::send(clients_.at(client).second, text.data(), text.size(), MSG_NOSIGNAL) > 0);
  }
  void hang_up(std::size_t client) {
    ::close(clients_.at(client).second);
    clients_.at(client).second = -1;
  }

 private:
  bench::MachineName name_;
  std::vector<std::pair<std::string, int>> clients_;
};

json status_of_run(const std::string& store, std::int64_t run) {
  return {{"bench", "page-words"}, {"run", run}, {"store", store}, {"state", "running"}};
}

std::unique_ptr<RawClient> send_word(const WordsPage& page, const std::string& word) {
  return page.send_command({{"word", word}, {"run", 4}});
}

bool is_live(const WordsPage& page) {
  RawClient viewer(page.server->port());
  (void)viewer.send(page.head("GET /events", page.server->access().read_token));
  return viewer.read(20'000, "\"unread\"").find("\"live\":true") != std::string::npos;
}

}  // namespace

TEST_CASE("silent run: sixteen commands wait, a further one is refused except panic, and each gets its result") {
  SocketRun run("page-words");
  WordsPage page;
  CHECK(run.accept() == "follow");
  run.tell(0, status_of_run(page.options.db, 4));
  REQUIRE(comes_true([&] { return is_live(page); }));
  std::vector<std::unique_ptr<RawClient>> waiting;
  for (int i = 0; i < 16; ++i) {
    waiting.push_back(send_word(page, i == 0 ? "pause" : "abort"));
    const std::string words = run.accept();
    CHECK_THAT(words, Catch::StartsWith(i == 0 ? "pause\n" : "abort\n") && Catch::Contains("bob"));
  }
  CHECK(WordsPage::answer_to(*send_word(page, "stop"))["taken"] == false);
  waiting.push_back(send_word(page, "panic"));
  CHECK_THAT(run.accept(), Catch::StartsWith("panic\n"));
  run.hang_up(1);
  CHECK(WordsPage::answer_to(*waiting[0])["taken"] == false);
  run.tell(2, {{"bench", "page-words"}, {"run", 4}, {"taken", true}, {"text", "it\nends"}});
  const json answered = WordsPage::answer_to(*waiting[1]);
  CHECK(answered["taken"] == true);
  CHECK_THAT(answered["text"].get<std::string>(), Catch::StartsWith("it") && Catch::EndsWith("ends"));
  for (std::size_t i = 2; i < 17; ++i) CHECK(WordsPage::answer_to(*waiting[i])["taken"] == false);
  auto again = send_word(page, "stop");  // there is room again
  CHECK_THAT(run.accept(), Catch::StartsWith("stop\n"));
}

TEST_CASE("silent run: a run that denies access or uses another store is not followed, invalid answers are ignored") {
  SocketRun run("page-words");
  WordsPage page;
  CHECK(run.accept() == "follow");
  run.tell(0, {{"bench", "page-words"}, {"denied", true}, {"text", "no"}});
  CHECK_FALSE(is_live(page));
  WordsPage other([&](bench::PageOptions& options) { options.db = page.options.db; });
  CHECK(run.accept() == "follow");
  const auto tell = [&](const std::string& text) { run.tell(1, text); };
  tell("no answer of a run");
  run.tell(1, status_of_run(page.options.db, 4));
  CHECK(comes_true([&] { return is_live(other); }));
  run.hang_up(1);
  CHECK(comes_true([&] { return !is_live(other); }));
}
