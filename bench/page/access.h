// Access to the page: one token for reading, one for commands, the request headers by which a browser shows which page
// the request comes from, and the addresses at which the page is reached.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "bench/page/http/message.h"

namespace tactbench::bench {

struct PageAccess {
  std::string read_token;     // part of the link; gives the right to read only
  std::string command_token;  // empty: nobody may command
  std::string operator_name;  // the person to whom the command token belongs
  std::vector<std::string>
      hosts;  // "127.0.0.1:8765": all names of this server that a browser may use, in the form of hosts_of()
  std::string scheme = "http";
};

enum class PageNeeds {
  kNothing,  // the page's own files, which hold no data
  kRead,
  kCommand,
};

// None: the request is allowed. Refuses, in this order: a foreign Host with 421 (an attacker's name that resolves to
// this address), a foreign Origin or site with 403, a change by anything other than the page's own POST with 405, 415
// or 403, and a missing or wrong token with 401. Never reveals which token would have been right.
std::optional<HttpResponse> refusal(const HttpRequest& request, PageNeeds needs, const PageAccess& access);

// Whether the request carries the operator's token; or at least one that may read.
bool may_command(const HttpRequest& request, const PageAccess& access);
bool may_read(const HttpRequest& request, const PageAccess& access);

// As a browser writes them: in lower case, and without the port if it is the default of the scheme.
std::vector<std::string> hosts_of(const std::vector<std::string>& names, std::uint16_t port, const std::string& scheme);

// 128 random bits as 32 hex digits.
std::string new_token();

// The addresses at which other machines reach this one.
// Addresses of the interfaces that are up, in the system's order, each once: "192.0.2.7", with `v6` also "2001:db8::7".
// Loopback and link-local addresses, which other machines cannot reach, are left out. Empty if there are none.
std::vector<std::string> own_addresses(bool v6);

}  // namespace tactbench::bench
