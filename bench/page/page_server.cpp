#include "bench/page/page_server.h"

#include <fmt/format.h>
#include <signal.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "analysis/json_io.h"
#include "analysis/report/report_facts.h"
#include "bench/common/terminal.h"
#include "bench/common/utc.h"
#include "bench/page/access.h"
#include "bench/page/assets.h"
#include "bench/page/commands.h"
#include "bench/page/displayed_run.h"
#include "bench/page/documents.h"
#include "bench/page/lists.h"
#include "bench/page/responses.h"

namespace tactbench::bench {

namespace {

enum EventKind { kReadings, kState, kPicture };

constexpr std::chrono::milliseconds kTick{100}, kStateAtMost{250}, kStateAtLeast{1000};
constexpr std::chrono::milliseconds kLookForRuns{250};
constexpr std::chrono::seconds kLeftAlone{60};  // after the process has ended

// If it listens on all addresses: those of the machine, loopback first.
std::vector<std::string> addresses_in_links(const HttpOptions& http) {
  std::vector<std::string> addresses = {http.address};
  if (http.address == "0.0.0.0" || http.address == "::") {
    addresses = own_addresses(http.address == "::");
    addresses.insert(addresses.begin(), "127.0.0.1");
  }
  for (std::string& address : addresses)
    if (address.find(':') != std::string::npos) address = "[" + address + "]";
  return addresses;
}

}  // namespace

struct PageServer::Parts {
  explicit Parts(const PageOptions& given)
      : options(given),
        addresses(addresses_in_links(given.http)),
        server(
            given.http, [this](const HttpRequest& request, Reply reply) { answer(request, std::move(reply)); },
            [this](const HttpRequest& request) {
              return may_command(request, access) ? kNeverEvicted : may_read(request, access) ? 1 : 0;
            }),
        show(given.db, given.bench),
        documents(given.db),
        commands(server),
        follower(server, given.db, given.bench, [this] { heard(); }) {
    access.read_token = new_token();
    if (!options.operator_name.empty()) access.command_token = new_token();
    access.operator_name = options.operator_name;
    access.scheme = options.http.certificate.empty() ? "http" : "https";
    std::vector<std::string> names = {"127.0.0.1", "localhost", "[::1]"};
    names.insert(names.end(), addresses.begin(), addresses.end());
    names.insert(names.end(), options.names.begin(), options.names.end());
    access.hosts = hosts_of(names, server.port(), access.scheme);
    server.every(kTick, [this] { tick(); });
  }

  [[nodiscard]] const LiveRun* live() const { return follower.live() ? &*follower.live() : nullptr; }

  void heard() {
    if (live() != nullptr) {
      server.publish(kReadings, event_text("readings", readings_json(*live())));
      const RunStatus& status = live()->status;
      const std::string now = fmt::format("{} {} {} {}", status.run, to_string(status.state), status.question_id,
                                          status.answer ? status.answer->question : 0);
      state_due = state_due || now != message;
      message = now;
    } else {
      state_due = true;
    }
    look();
  }

  void look() {
    show.look(live());
    if (show.consume_new_picture()) server.publish(kPicture, event_text("picture", show.picture()));
  }

  void tick() {
    const auto now = std::chrono::steady_clock::now();
    documents.look();
    commands.look();
    if (now - looked >= kLookForRuns) {
      looked = now;
      follower.look();
      look();
      if (ended && ended()) server.stop();
    }
    const auto since = now - state_sent_at;
    if (since < kStateAtMost || (!state_due && since < kStateAtLeast)) return;
    state_due = false;
    state_sent_at = now;
    server.publish(kState, event_text("state", show.state(live(), follower.silent_s())));
  }

  // The first event of a new viewer: its rights, and the present state.
  SharedText greeting(const HttpRequest& request) {
    const nlohmann::json hello = {{"operator", may_command(request, access) ? access.operator_name : ""},
                                  {"commands", !access.command_token.empty()},
                                  {"night", !options.night.empty()}};
    std::string text = "retry: 1000\n\n" + *event_text("hello", hello);
    text += *event_text("state", show.state(live(), follower.silent_s()));
    const nlohmann::json picture = show.picture();
    if (!picture.is_null()) text += *event_text("picture", picture);
    return std::make_shared<const std::string>(std::move(text));
  }

  void answer(const HttpRequest& request, Reply reply) {
    const std::optional<PageNeeds> needs = needs_of(request.path);
    if (std::optional<HttpResponse> refused = refusal(request, needs.value_or(PageNeeds::kNothing), access))
      return reply(guarded(*std::move(refused)));
    if (!needs) return reply(guarded(text_response(404, "there is no such path\n")));
    try {
      route(request, [reply](HttpResponse response) { reply(guarded(std::move(response))); });
    } catch (const std::exception& error) {
      reply(guarded(json_response(500, {{"error", one_line(error.what(), kMaxTextLength)}})));
    }
  }

  void route(const HttpRequest& request, const Reply& reply) {
    if (const std::optional<HttpResponse> file = page_asset(request.path)) return reply(*file);
    if (request.path == "/events")
      return reply({.type = "text/event-stream", .body = greeting(request), .fields = {}, .stream = true});
    if (request.path == "/command") return command(request, reply);
    if (request.path.starts_with(kDocumentPath)) {
      const std::optional<std::string> text = documents.text(request.path.substr(std::string(kDocumentPath).size()));
      return reply(text ? document_response(*text)
                        : text_response(404, "this document no longer exists: request it again\n"));
    }
    std::string why;
    const db::RunStore* store = show.store(&why);
    if (store == nullptr) return reply(json_response(503, {{"error", one_line(why, kMaxTextLength)}}));
    if (request.path == "/loop") return reply(json_response(200, loop(*store, request)));
    if (request.path == "/runs") return reply(json_response(200, runs_list(*store)));
    if (request.path == "/sensors")
      return reply(json_response(200, sensors_list(*store, options.laboratory, analysis::date_of(utc_now()))));
    make_document(*store, request, reply);
  }

  static nlohmann::json loop(const db::RunStore& store, const HttpRequest& request) {
    return loop_points(store, number_in(request, "run"), static_cast<int>(number_in(request, "taxel", -1)),
                       number_in(request, "after"));
  }

  void command(const HttpRequest& request, const Reply& reply) {
    const std::string behalf = fmt::format("{} on the page, from {}", one_line(access.operator_name, 60), request.from);
    commands.send(request.body, live(), behalf, [reply, behalf, body = request.body](const HttpResponse& response) {
      tty::print(stderr, "{} {}: {}\n", behalf, one_line(body), response.body ? one_line(*response.body) : "");
      reply(response);
    });
  }

  // Only numbers that are runs, and serials that are registered, become words of a command line.
  void make_document(const db::RunStore& store, const HttpRequest& request, const Reply& reply) {
    const auto ready = [reply](const Document& made) {
      reply(made.error.empty() ? json_response(200, {{"path", kDocumentPath + made.id}})
                               : json_response(500, {{"error", made.error}}));
    };
    const std::string kind = request.path.substr(std::string("/make/").size());
    if (kind == "report") {
      return documents.make({"report", std::to_string(store.run(number_in(request, "run")).run)}, "-o", ready);
    }
    if (kind == "compare") {
      const std::int64_t first = store.run(number_in(request, "run")).run;
      const std::int64_t second = store.run(number_in(request, "with")).run;
      return documents.make({"report", "--compare", std::to_string(first), std::to_string(second)}, "-o", ready);
    }
    if (kind == "sensor") {
      const auto serial = request.query.find("serial");
      const std::optional<db::SensorRecord> sensor =
          serial == request.query.end() ? std::nullopt : store.sensor(serial->second);
      if (!sensor) return reply(json_response(404, {{"error", "there is no such sensor"}}));
      return documents.make({"trend", "--sensor=" + sensor->serial}, "--html", ready);
    }
    if (kind == "nights") return documents.make({"trend", "--subject=nightly/"}, "--html", ready);
    if (kind == "night" && !options.night.empty()) return ready(documents.keep(options.night));
    reply(json_response(404, {{"error", "there is no such document"}}));
  }

  const PageOptions options;
  const std::vector<std::string> addresses;  // as they appear in links
  PageAccess access;
  HttpServer server;
  DisplayedRun show;
  Documents documents;
  Commands commands;
  RunFollower follower;
  std::function<bool()> ended;
  std::string message;
  bool state_due = true;
  std::chrono::steady_clock::time_point state_sent_at{}, looked{};
};

PageServer::PageServer(const PageOptions& options) : parts_(std::make_unique<Parts>(options)) {}
PageServer::~PageServer() = default;

const PageAccess& PageServer::access() const { return parts_->access; }
std::uint16_t PageServer::port() const { return parts_->server.port(); }

std::vector<std::string> PageServer::readers_links() const {
  std::vector<std::string> links;
  for (const std::string& address : parts_->addresses)
    links.push_back(fmt::format("{}://{}:{}/#{}", access().scheme, address, port(), access().read_token));
  return links;
}

std::vector<std::string> PageServer::links() const {
  std::vector<std::string> links = readers_links();
  if (!access().command_token.empty())
    for (std::string& link : links) link += "." + access().command_token;
  return links;
}

void PageServer::serve(const std::function<bool()>& ended) {
  auto last_seen = std::chrono::steady_clock::now();
  bool ever_seen = false;
  parts_->ended = [&, run_process = parts_->options.run_process] {
    const auto now = std::chrono::steady_clock::now();
    if (parts_->server.viewers() > 0) {
      last_seen = now;
      ever_seen = true;
    }
    const bool gone = run_process != 0 && ::kill(static_cast<pid_t>(run_process), 0) != 0;
    return ended() || (gone && (!ever_seen || now - last_seen >= kLeftAlone));
  };
  parts_->server.run();
  parts_->ended = {};
}

void PageServer::stop() { parts_->server.stop(); }

}  // namespace tactbench::bench
