#include "analysis/workers.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace tactbench::analysis {

void for_each_index(std::size_t count, int threads, const std::function<void(std::size_t)>& work) {
  const std::size_t wanted =
      threads > 0 ? static_cast<std::size_t>(threads) : std::max<std::size_t>(1, std::thread::hardware_concurrency());
  Work counted(count);
  std::atomic<std::size_t> next{0};
  std::mutex mutex;
  std::exception_ptr failure;
  std::size_t failed_at = count;
  const auto run = [&] {
    for (std::size_t i = next++; i < count; i = next++) {
      try {
        work(i);
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (i < failed_at) {
          failed_at = i;
          failure = std::current_exception();
        }
      }
      counted.add();
    }
  };
  std::vector<std::jthread> helpers;
  for (std::size_t i = 1; i < std::min(wanted, count); ++i) helpers.emplace_back(run);
  run();
  helpers.clear();  // joins
  if (failure) std::rethrow_exception(failure);
}

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
