#include "bench/benchmarks/page_viewers.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>

#include "analysis/json_io.h"
#include "bench/common/file_text.h"

namespace tactbench::bench {

namespace {

int open_for_writing(const std::string& path) {
  return ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
}

ChildStart page_start(const std::string& program, const std::string& db, const std::string& log) {
  return {.words = {program.empty() ? "/proc/self/exe" : program, "page", "--db", db, "--port", "0", "--json"},
          .environment = environment_with({}),
          .output = open_for_writing(log),
          .ends_with_us = true};
}

int connected_to(std::uint16_t port) {
  const int descriptor = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in place{};
  place.sin_family = AF_INET;
  place.sin_port = htons(port);
  place.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (::connect(descriptor, reinterpret_cast<const sockaddr*>(&place), sizeof place) != 0)
    throw std::runtime_error("the page takes no connection");
  return descriptor;
}

}  // namespace

PageProcess::PageProcess(const std::string& db, const std::string& folder, const std::string& program)
    : child_(page_start(program, db, folder + "/page.log")) {
  for (int i = 0; i < 1000 && port_ == 0; ++i) {
    const bool ended = child_.ended().has_value();
    const nlohmann::json told = analysis::try_json(file_text(folder + "/page.log"));
    if (told.is_object()) {
      port_ = told.value("port", std::uint16_t{0});
      const std::string link = told.value("readers_link", "");
      token_ = link.substr(link.find('#') + 1);
    }
    if (ended) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  if (port_ == 0) throw std::runtime_error("the page does not start: " + file_text(folder + "/page.log"));
}

double processor_seconds_of(const std::string& stat, double ticks_per_second) {
  std::istringstream words(stat.substr(stat.rfind(')') + 2));  // after the name, from the state on
  std::vector<std::string> fields{std::istream_iterator<std::string>(words), {}};
  return (std::atof(fields.at(11).c_str()) + std::atof(fields.at(12).c_str())) / ticks_per_second;
}

double resident_mb_of(const std::string& status) {
  const std::string_view name = "VmHWM:";
  const std::size_t at = status.find(name);
  return at == std::string::npos ? 0.0 : std::atof(status.c_str() + at + name.size()) / 1024.0;
}

double PageProcess::processor_s() const {
  return processor_seconds_of(file_text(fmt::format("/proc/{}/stat", child_.process())),
                              static_cast<double>(::sysconf(_SC_CLK_TCK)));
}

double PageProcess::resident_mb() const {
  return resident_mb_of(file_text(fmt::format("/proc/{}/status", child_.process())));
}

PageViewers::PageViewers(std::uint16_t port, const std::string& token, int viewers, int frozen)
    : reading_(static_cast<std::size_t>(viewers - frozen)) {
  const std::string get =
      fmt::format("GET /events HTTP/1.1\r\nHost: 127.0.0.1:{}\r\nAuthorization: Bearer {}\r\n\r\n", port, token);
  for (int i = 0; i < viewers; ++i) {
    descriptors_.push_back(connected_to(port));
    if (::send(descriptors_.back(), get.data(), get.size(), MSG_NOSIGNAL) < 0)
      throw std::runtime_error("the page hangs up");
  }
  thread_ = std::thread([this] { read(); });
}

PageViewers::~PageViewers() {
  ended_ = true;
  if (thread_.joinable()) thread_.join();
  for (const int descriptor : descriptors_) ::close(descriptor);
}

void PictureTimes::take(const std::string& bytes, Time now) {
  text_ += bytes;
  constexpr std::string_view kPicture = "event: picture\n", kPosition = "\"position\":";
  for (std::size_t at = text_.find(kPicture, looked_); at != std::string::npos; at = text_.find(kPicture, looked_)) {
    const std::size_t end = text_.find("\n\n", at);
    if (end == std::string::npos) return;
    const std::size_t position = text_.find(kPosition, at);
    if (position < end) times_.try_emplace(std::atoll(text_.c_str() + position + kPosition.size()), now);
    looked_ = end;
  }
}

void PageViewers::read() {
  std::vector<pollfd> ready;
  for (std::size_t i = 0; i < reading_; ++i) ready.push_back({descriptors_[i], POLLIN, 0});
  std::array<char, 65536> bytes{};
  while (!ended_) {
    (void)::poll(ready.data(), ready.size(), 20);
    for (std::size_t i = 0; i < ready.size(); ++i) {
      if ((ready[i].revents & POLLIN) == 0) continue;
      const ssize_t size = ::recv(ready[i].fd, bytes.data(), bytes.size(), MSG_DONTWAIT);
      if (size > 0 && i == 0) pictures_.take({bytes.data(), static_cast<std::size_t>(size)}, RealClock::now());
    }
  }
}

const std::map<std::int64_t, PageViewers::RealClock::time_point>& PageViewers::pictures() {
  ended_ = true;
  if (thread_.joinable()) thread_.join();
  return pictures_.times();
}

const std::string& PageViewers::text() {
  (void)pictures();
  return pictures_.text();
}

}  // namespace tactbench::bench
