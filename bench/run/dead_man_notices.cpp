#include "bench/run/dead_man_notices.h"

#include <fmt/format.h>

#include "bench/common/terminal_safe.h"
#include "bench/rig/rig.h"
#include "bench/run/control/progress.h"
#include "bench/run/recorder.h"
#include "devices/device.h"

namespace tactbench::bench {

namespace {

std::string news_in_words(const DeadManNews& news) {
  return news.id.empty() ? news.what : fmt::format("warning: {} [{}]", news.what, news.id);
}

}  // namespace

void record_news(Rig& rig, Recorder& recorder, Progress& progress) {
  const auto record = [&](const char* kind, const DeadManNews& news) {
    recorder.event(kind, news.id, news.what);
    progress.note(news_in_words(news));
  };
  for (const std::string& words : rig.take_busy()) record("warning", {"TB-MODBUS-BUSY", words});
  if (rig.dead_man() == nullptr) return;
  for (const DeadManNews& news : rig.dead_man()->take_news()) record("dead-man", news);
}

void tell_dead_man_news(Rig& rig) {
  if (rig.dead_man() == nullptr) return;
  for (const DeadManNews& news : rig.dead_man()->take_news()) tty::print(stderr, "{}\n", news_in_words(news));
}

void check_dead_man(Rig& rig) {
  if (rig.dead_man() == nullptr) return;
  if (const auto lost = rig.dead_man()->lost()) throw devices::Fault(lost->id, "dead-man", lost->what, lost->remedy);
}

}  // namespace tactbench::bench
