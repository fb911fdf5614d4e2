#include "bench/run/dead_man_notices.h"

#include <fmt/format.h>

#include "bench/common/terminal_safe.h"
#include "bench/rig/rig.h"
#include "bench/run/control/progress.h"
#include "bench/run/recorder.h"
#include "devices/device.h"

namespace tactbench::bench {

namespace {

std::string notice_text(const DeadManNotice& news) {
  return news.id.empty() ? news.what : fmt::format("warning: {} [{}]", news.what, news.id);
}

}  // namespace

void record_notices(Rig& rig, Recorder& recorder, Progress& progress) {
  const auto record = [&](const char* kind, const DeadManNotice& news) {
    recorder.event(kind, news.id, news.what);
    progress.note(notice_text(news));
  };
  for (const std::string& words : rig.take_busy_report()) record("warning", {"TB-MODBUS-BUSY", words});
  if (rig.dead_man() == nullptr) return;
  for (const DeadManNotice& news : rig.dead_man()->take_notices()) record("dead-man", news);
}

void print_dead_man_notices(Rig& rig) {
  if (rig.dead_man() == nullptr) return;
  for (const DeadManNotice& news : rig.dead_man()->take_notices()) tty::print(stderr, "{}\n", notice_text(news));
}

void check_dead_man(Rig& rig) {
  if (rig.dead_man() == nullptr) return;
  if (const auto lost = rig.dead_man()->lost()) throw devices::Fault(lost->id, "dead-man", lost->what, lost->remedy);
}

}  // namespace tactbench::bench
