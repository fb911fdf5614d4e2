// Where the simulated ends of this process were found: ports, terminals and sockets that are others in each run. What
// is stored of a run names them by words that last, so that the same seed gives the same content, also where an error
// quotes an address.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace tactbench::bench {

class PassingNames {
 public:
  // Of an address as it is served: "Modbus TCP 127.0.0.1:40001, ADAM-6024", "/dev/pts/3", "/tmp/x/scanner".
  void add(const std::string& where);
  // "... of 127.0.0.1:40001 unit 1" as "... of 127.0.0.1:PORT unit 1".
  [[nodiscard]] std::string lasting(std::string text) const;

 private:
  std::vector<std::pair<std::string, std::string>> names_;
};

}  // namespace tactbench::bench
