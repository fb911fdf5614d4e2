// Limits the number of further descriptors that this process may open, during the object's lifetime.
#pragma once

#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <stdexcept>
#include <vector>

namespace tactbench::tests {

class FewDescriptors {
 public:
  explicit FewDescriptors(int left) {
    if (::getrlimit(RLIMIT_NOFILE, &before_) != 0) throw std::runtime_error("no limit of descriptors");
    rlimit few = before_;
    few.rlim_cur = static_cast<rlim_t>(std::max(2, open().back()) + 1 + left);
    if (::setrlimit(RLIMIT_NOFILE, &few) != 0) throw std::runtime_error("the limit of descriptors is fixed");
    for (int copy = ::dup(2); copy >= 0; copy = ::dup(2)) taken_.push_back(copy);
    for (int i = 0; i < left; ++i, taken_.pop_back()) ::close(taken_.back());
  }
  ~FewDescriptors() {
    for (const int copy : taken_) ::close(copy);
    ::setrlimit(RLIMIT_NOFILE, &before_);
  }
  FewDescriptors(const FewDescriptors&) = delete;
  FewDescriptors& operator=(const FewDescriptors&) = delete;

  // Those that are open, ascending.
  [[nodiscard]] static std::vector<int> open() {
    std::vector<int> all;
    for (int i = 0; i < 1024; ++i)
      if (::fcntl(i, F_GETFD) >= 0) all.push_back(i);
    return all;
  }

 private:
  rlimit before_{};
  std::vector<int> taken_;
};

}  // namespace tactbench::tests
