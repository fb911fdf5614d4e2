// The addresses at which other machines reach this one.
#pragma once

#include <string>
#include <vector>

namespace tactbench::bench {

// Addresses of the interfaces that are up, in the system's order, each once: "192.0.2.7", with `v6` also "2001:db8::7".
// Loopback and link-local addresses, which other machines cannot reach, are left out. Empty if there are none.
std::vector<std::string> own_addresses(bool v6);

}  // namespace tactbench::bench
