#include "bench/simulation/ephemeral_addresses.h"

#include <cctype>

namespace tactbench::bench {

namespace {

bool is_digit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

}  // namespace

void EphemeralAddresses::add(const std::string& where) {
  const std::string host = "127.0.0.1";
  if (const std::size_t found = where.find(host + ":"); found != std::string::npos) {
    std::string port;
    for (std::size_t i = found + host.size() + 1; i < where.size() && is_digit(where[i]); ++i) port += where[i];
    names_.emplace_back(host + ":" + port, host + ":PORT");
    names_.emplace_back(host + " port " + port, host + " port PORT");
  } else if (const std::size_t path = where.find('/'); path != std::string::npos) {
    const std::string file = where.substr(path, where.find_first_of(", ", path) - path);
    names_.emplace_back(file, file.starts_with("/dev/pts/") ? "/dev/pts/N" : "SOCKET");
  }
}

std::string EphemeralAddresses::lasting(std::string text) const {
  for (const auto& [passing, name] : names_) {
    for (std::size_t at = 0; (at = text.find(passing, at)) != std::string::npos;) {
      const std::size_t end = at + passing.size();
      if (end < text.size() && is_digit(text[end])) {  // another one, whose name begins like this
        at = end;
        continue;
      }
      text.replace(at, passing.size(), name);
      at += name.size();
    }
  }
  return text;
}

}  // namespace tactbench::bench
