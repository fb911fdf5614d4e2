// HTML documents that other verbs write, shown in the page's frame: reports, comparisons, trends. Each is made by this
// program in a separate process, so that the verb and the page show the same content and the server stays small and
// responsive.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "bench/common/child_process.h"
#include "bench/common/private_files.h"

namespace tactbench::bench {

struct Document {
  std::string id;     // unguessable: anyone who knows it may read the document
  std::string error;  // reason why it could not be made; then there is no id
};

class Documents {
 public:
  // `program`: path of this program; tests give another.
  Documents(std::string db, std::string program = "/proc/self/exe");

  using Ready = std::function<void(const Document&)>;
  // `arguments`: the command line without the store and the output file: {"report", "5"}, `output` "-o"; `ready` is
  // called once, from here or from look(). At most two are made at a time; others wait, up to a limit.
  void make(const std::vector<std::string>& arguments, const std::string& output, Ready ready);
  // Keeps the present content of an existing file.
  Document keep(const std::string& path);
  void look();  // to be called many times per second
  [[nodiscard]] bool busy() const { return !working_.empty(); }
  // The document's text; none: there is no document with that id, or no longer.
  [[nodiscard]] std::optional<std::string> text(const std::string& id) const;

 private:
  struct Work {
    std::vector<std::string> arguments;
    std::string output, id;
    Ready ready;
    std::optional<ChildProgram> child;
    std::chrono::steady_clock::time_point begun{};
  };
  void start(Work& work);
  void finish(Work& work);
  [[nodiscard]] std::string path_of(const std::string& id) const;
  void forget_old();

  std::string db_, program_;
  ScratchFolder folder_;
  std::deque<Work> working_;
  std::deque<std::string> kept_;  // ids, oldest first
};

}  // namespace tactbench::bench
