// By which addresses other machines reach this one.
#pragma once

#include <string>
#include <vector>

namespace tactbench::bench {

// Of the interfaces that are up, in the system's order, each once: "192.0.2.7", with `v6` also "2001:db8::7". Loopback
// and link-local addresses, which lead nowhere from elsewhere, are left out. Empty where the system names none.
std::vector<std::string> own_addresses(bool v6);

}  // namespace tactbench::bench
