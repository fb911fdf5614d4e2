// Distributes independent pieces of work over threads; the result of each piece does not depend on their number.
#pragma once

#include <cstddef>
#include <functional>

namespace tactbench::analysis {

// Calls work(0..count-1), each once, on `threads` threads (0: as many as there are cores). Rethrows the exception of
// the lowest index that failed, after all threads have ended.
void for_each_index(std::size_t count, int threads, const std::function<void(std::size_t)>& work);

// Counts the progress of the current work, for display: work that is split into many equal pieces (workers.h, rows of a
// table). One count per program; counting never blocks.
struct WorkNow {
  std::size_t works = 0;            // works begun since the program started
  std::size_t done = 0, count = 0;  // pieces of the current work; count 0: none
};
WorkNow work_now();  // from any thread

// Counts `count` pieces during its lifetime. Nested in another one, on any thread, it counts nothing: its pieces are
// part of one piece.
class Work {
 public:
  explicit Work(std::size_t count);
  ~Work();
  Work(const Work&) = delete;
  Work& operator=(const Work&) = delete;
  void add(std::size_t pieces = 1);  // from any thread

 private:
  bool counts_;
};

}  // namespace tactbench::analysis
