#include "devices/wire/ends/end_activity.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>

namespace tactbench::devices {
namespace {

constexpr timespec kNow{0, 0};
constexpr Nanoseconds::rep kSecond = 1'000'000'000;

std::mutex& ends_mutex() {
  static std::mutex mutex;
  return mutex;
}

std::vector<EndActivity*>& ends() {
  static std::vector<EndActivity*> ends;
  return ends;
}

}  // namespace

EndActivity::EndActivity() : process_(::getpid()) {
  const std::lock_guard lock(ends_mutex());
  ends().push_back(this);
}

EndActivity::~EndActivity() {
  const std::lock_guard lock(ends_mutex());
  std::erase(ends(), this);
}

int EndActivity::wait(std::span<pollfd> descriptors, std::optional<Nanoseconds> longest) {
  const timespec span{longest ? longest->count() / kSecond : 0, longest ? longest->count() % kSecond : 0};
  {
    const std::lock_guard lock(mutex_);
    watched_.assign(descriptors.begin(), descriptors.end());
    waits_ = true;
  }
  const int ready = ::ppoll(descriptors.data(), descriptors.size(), longest ? &span : nullptr, nullptr);
  const int error = errno;
  {
    const std::lock_guard lock(mutex_);
    waits_ = false;
  }
  errno = error;
  return ready;
}

void EndActivity::leave() {
  const std::lock_guard lock(mutex_);
  left_ = true;
}

bool EndActivity::works() {
  if (process_ != ::getpid()) return false;
  const std::lock_guard lock(mutex_);
  if (left_) return false;
  // It may have bytes to read that it has not noticed yet.
  return !waits_ || ::ppoll(watched_.data(), watched_.size(), &kNow, nullptr) > 0;
}

bool EndActivity::any() {
  const std::lock_guard lock(ends_mutex());
  return std::any_of(ends().begin(), ends().end(), [](EndActivity* end) { return end->works(); });
}

}  // namespace tactbench::devices
