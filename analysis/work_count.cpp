#include "analysis/work_count.h"

#include <atomic>

namespace tactbench::analysis {
namespace {

std::atomic<std::size_t> works{0}, done{0}, planned{0};
std::atomic<bool> taken{false};

}  // namespace

WorkNow work_now() { return {works.load(), done.load(), planned.load()}; }

Work::Work(std::size_t pieces) : counts_(!taken.exchange(true)) {
  if (!counts_) return;
  done = 0;
  planned = pieces;
  ++works;
}

Work::~Work() {
  if (!counts_) return;
  planned = 0;
  taken = false;
}

void Work::add(std::size_t pieces) {
  if (counts_) done.fetch_add(pieces, std::memory_order_relaxed);
}

}  // namespace tactbench::analysis
