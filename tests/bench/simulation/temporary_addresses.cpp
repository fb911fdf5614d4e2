#include <catch2/catch.hpp>

#include "bench/simulation/ephemeral_addresses.h"

using tactbench::bench::EphemeralAddresses;

TEST_CASE("temporary addresses: those of simulated ends are replaced by fixed text, others are unchanged") {
  EphemeralAddresses names;
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

TEST_CASE("temporary addresses: how the end of a path, a port and the text is recognised") {
  EphemeralAddresses names;
  names.add("no address");
  CHECK(names.lasting("no address at 127.0.0.1:9") == "no address at 127.0.0.1:9");
  names.add("on /tmp/a,b and more");
  names.add("see 127.0.0.1:40");
  names.add("/dev/pts/12 of a line");
  CHECK(names.lasting("/tmp/a") == "SOCKET");
  CHECK(names.lasting("/tmp/a,b") == "SOCKET,b");
  CHECK(names.lasting("127.0.0.1:401, 127.0.0.1:40") == "127.0.0.1:401, 127.0.0.1:PORT");
  CHECK(names.lasting("127.0.0.1 port 40") == "127.0.0.1 port PORT");
  CHECK(names.lasting("127.0.0.1 port 400") == "127.0.0.1 port 400");
  CHECK(names.lasting("/dev/pts/12/dev/pts/12") == "/dev/pts/N/dev/pts/N");
  CHECK(names.lasting("/dev/pts/123 /dev/pts/12") == "/dev/pts/123 /dev/pts/N");
  CHECK(names.lasting("").empty());
}
