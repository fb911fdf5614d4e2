#include "bench/page/documents.h"

#include <fcntl.h>
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <system_error>
#include <utility>

#include "bench/common/private_files.h"
#include "bench/common/terminal.h"
#include "bench/page/access.h"

namespace tactbench::bench {

namespace {

constexpr std::size_t kAtOnce = 2, kWaiting = 6, kKept = 12;
constexpr std::chrono::seconds kLongestWork{180};
constexpr std::uintmax_t kLargest = 32U << 20U;

bool is_id(const std::string& text) {
  return !text.empty() && text.find_first_not_of("0123456789abcdef") == std::string::npos;
}

}  // namespace

Documents::Documents(std::string db, std::string program)
    : db_(std::filesystem::absolute(db).string()), program_(std::move(program)), folder_("tactbench-page") {}

std::string Documents::path_of(const std::string& id) const { return fmt::format("{}/{}.html", folder_.path(), id); }

void Documents::make(const std::vector<std::string>& arguments, const std::string& output, Ready ready) {
  if (working_.size() >= kAtOnce + kWaiting) return ready({"", "too many documents are being made: try again soon"});
  working_.push_back({arguments, output, new_token(), std::move(ready), {}, {}});
  look();
}

Document Documents::keep(const std::string& path) {
  const std::string id = new_token();
  std::error_code error;
  std::filesystem::copy_file(path, path_of(id), error);
  if (error) return {"", fmt::format("{}: {}", path, error.message())};
  kept_.push_back(id);
  forget_old();
  return {id, ""};
}

void Documents::start(Work& work) {
  work.begun = std::chrono::steady_clock::now();
  std::vector<std::string> arguments = {program_};
  arguments.insert(arguments.end(), work.arguments.begin(), work.arguments.end());
  arguments.insert(arguments.end(), {"--db", db_, work.output, path_of(work.id)});
  const std::string log = path_of(work.id) + ".log";
  try {
    const int output = ::open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    work.child.emplace(ChildStart{arguments, environment_with({"NO_COLOR=1"}), output, true});
  } catch (const std::system_error& error) {
    std::ofstream(log) << "cannot start: " << error.what() << "\n";
  }
}

void Documents::finish(Work& work) {
  const std::string path = path_of(work.id), log = path + ".log";
  std::error_code ignored;
  Document made{work.id, ""};
  if (std::filesystem::exists(path, ignored)) {
    kept_.push_back(work.id);
    forget_old();
  } else {
    made = {"", terminal_safe(file_text(log).substr(0, kMaxTextLength))};
    if (made.error.empty()) made.error = "it took too long";
  }
  std::filesystem::remove(log, ignored);
  work.ready(made);
}

void Documents::look() {
  const auto now = std::chrono::steady_clock::now();
  std::size_t under_way = 0;
  std::vector<Work> ended;
  for (auto work = working_.begin(); work != working_.end();) {
    if (!work->child && under_way < kAtOnce) start(*work);
    if (work->child && !work->child->ended() && now - work->begun > kLongestWork) work->child->kill_group();
    const bool done = work->begun != std::chrono::steady_clock::time_point{} && (!work->child || work->child->ended());
    if (done) {
      ended.push_back(std::move(*work));
      work = working_.erase(work);
      continue;
    }
    under_way += work->child ? 1 : 0;
    ++work;
  }
  for (Work& work : ended) finish(work);  // may ask for another
}

void Documents::forget_old() {
  while (kept_.size() > kKept) {
    std::error_code ignored;
    std::filesystem::remove(path_of(kept_.front()), ignored);
    kept_.pop_front();
  }
}

std::optional<std::string> Documents::text(const std::string& id) const {
  if (!is_id(id) || std::ranges::find(kept_, id) == kept_.end()) return std::nullopt;
  std::error_code error;
  if (std::filesystem::file_size(path_of(id), error) > kLargest || error) return std::nullopt;
  return file_text(path_of(id));
}

}  // namespace tactbench::bench
