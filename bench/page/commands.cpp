#include "bench/page/commands.h"

#include <fmt/format.h>

#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "analysis/json_io.h"
#include "bench/common/terminal.h"
#include "bench/run/control/control_client.h"

namespace tactbench::bench {

namespace {

constexpr std::chrono::seconds kLongestWait{5};
constexpr std::size_t kMostUnderWay = 16;  // a panic has as many separate places
constexpr int kLargestNumber = std::numeric_limits<int>::max();

HttpResponse answer_json(int status, bool taken, const std::string& text, const std::string& by = {}) {
  return {.status = status,
          .type = "application/json",
          .body = std::make_shared<const std::string>(
              analysis::printable_json(nlohmann::json{{"taken", taken}, {"text", text}, {"by", by}}))};
}

struct Asked {
  std::int64_t run = 0;
  std::string packet;  // for the control socket
  bool panics = false;
};

// None: it is not a command of the page.
std::optional<Asked> read_command(const std::string& body, const std::string& behalf) {
  const nlohmann::json json = analysis::try_json(body);
  if (!json.is_object()) return std::nullopt;
  for (const char* number : {"run", "question"})
    if (json.contains(number) && !(json[number].is_number_integer() && json[number] <= kLargestNumber))
      return std::nullopt;
  try {
    Asked asked;
    asked.run = json.value("run", std::int64_t{0});
    const std::string word = json.value("word", "");
    if (word == "answer") {
      asked.packet = answer_packet(json.value("question", 0), json.value("text", ""), behalf);
      return asked;
    }
    for (const Command command :
         {Command::kPause, Command::kResume, Command::kStop, Command::kAbort, Command::kPanic}) {
      if (word != to_string(command)) continue;
      asked.packet = command_packet(command, behalf);
      asked.panics = command == Command::kPanic;
      return asked;
    }
  } catch (const nlohmann::json::exception&) {  // a member of another type
  }
  return std::nullopt;
}

}  // namespace

void Commands::send(const std::string& body, const LiveRun* live, const std::string& behalf, Reply reply) {
  const std::optional<Asked> asked = read_command(body, behalf);
  if (!asked) return reply(answer_json(400, false, "this is not a command of the page"));
  if (live == nullptr) return reply(answer_json(200, false, "no run is live"));
  if (asked->run != live->status.run)
    return reply(answer_json(200, false, fmt::format("run {} is live now, not run {}", live->status.run, asked->run)));
  if (sent_.size() >= (asked->panics ? 2 : 1) * kMostUnderWay)
    return reply(answer_json(200, false, "too many commands wait for the run"));
  auto connection = std::make_unique<RunConnection>(live->name, asked->packet, live->status.store);
  if (!connection->open()) return reply(answer_json(200, false, fmt::format("run {} does not answer", asked->run)));
  Sent& sent = sent_.emplace_back();
  sent.connection = std::move(connection);
  sent.reply = std::move(reply);
  sent.begun = std::chrono::steady_clock::now();
  sent.watching = server_.watch(sent.connection->descriptor(), [this, &sent] { receive(sent); });
}

void Commands::receive(Sent& sent) {
  if (sent.done) return;
  const std::optional<LiveRun> answer = sent.connection->newest();
  if (!answer && sent.connection->open()) return;
  sent.done = true;  // look() removes it: this function is called by the object to be removed
  if (!answer) return sent.reply(answer_json(200, false, "the run closed the connection without an answer"));
  sent.reply(answer_json(200, answer->taken, one_line(answer->text, kMaxReplyColumns), peer_text(answer->server)));
}

void Commands::look() {
  const auto now = std::chrono::steady_clock::now();
  for (Sent& sent : sent_) {
    if (sent.done || now - sent.begun < kLongestWait) continue;
    sent.done = true;
    sent.reply(
        answer_json(200, false,
                    fmt::format("the run has not acknowledged within {} s: its process is stopped, or waits for an "
                                "instrument; check the rig",
                                kLongestWait.count())));
  }
  sent_.remove_if([](const Sent& sent) { return sent.done; });
}

}  // namespace tactbench::bench
