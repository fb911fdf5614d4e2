#include "bench/simulation/passing_names.h"

#include <catch2/catch.hpp>

using tactbench::bench::PassingNames;

TEST_CASE("addresses of simulated ends are stored by names that last, those of others as they are") {
  PassingNames names;
  names.add("Modbus TCP 127.0.0.1:4000, ADAM-6024");
  names.add("Modbus RTU /dev/pts/3, RS-485");
  names.add("/tmp/tactbench-BIoHmf/scanner");
  names.add("http://127.0.0.1:555/netftapi2.xml");
  CHECK(names.lasting("of 127.0.0.1:4000 unit 1, again 127.0.0.1:4000") ==
        "of 127.0.0.1:PORT unit 1, again 127.0.0.1:PORT");
  CHECK(names.lasting("at 127.0.0.1 port 555 (UDP)") == "at 127.0.0.1 port PORT (UDP)");
  CHECK(names.lasting("packet socket /tmp/tactbench-BIoHmf/scanner: none") == "packet socket SOCKET: none");
  CHECK(names.lasting("/dev/pts/3: none") == "/dev/pts/N: none");
  // Names that only begin like these, and addresses of a real rig.
  for (const char* other : {"127.0.0.1:40001", "/dev/pts/31", "192.168.0.7:4000", "127.0.0.1:502"})
    CHECK(names.lasting(other) == other);
}
