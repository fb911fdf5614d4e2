// Addresses of the simulated instruments of this process: ports, terminals and sockets that differ from run to run.
// Before a run's texts are stored, they are replaced by constant names, so that the same seed gives the same content,
// even if an error message quotes an address.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace tactbench::bench {

class EphemeralAddresses {
 public:
  // Adds an address as it is served: "Modbus TCP 127.0.0.1:40001, ADAM-6024", "/dev/pts/3", "/tmp/x/scanner".
  void add(const std::string& where);
  // "... of 127.0.0.1:40001 unit 1" becomes "... of 127.0.0.1:PORT unit 1".
  [[nodiscard]] std::string lasting(std::string text) const;

 private:
  std::vector<std::pair<std::string, std::string>> names_;
};

}  // namespace tactbench::bench
