#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "tests/bench/page/served_page.h"

namespace tactbench::tests {

nlohmann::json WordsPage::data_of(const std::string& path, int status) const {
  const std::string answer = get(path);
  INFO(path << ": " << answer);
  CHECK(status_of(answer) == status);
  return nlohmann::json::parse(body_of(answer));
}

nlohmann::json WordsPage::command(const nlohmann::json& words) const {
  const std::string body = words.dump();
  RawClient client(server->port());
  (void)client.send(head("POST /command", server->access().command_token,
                         fmt::format("Connection: close\r\nContent-Type: application/json\r\nX-Tactbench: "
                                     "1\r\nContent-Length: {}\r\n",
                                     body.size())) +
                    body);
  const std::string answer = client.read();
  INFO(answer);
  CHECK(status_of(answer) == 200);
  return nlohmann::json::parse(body_of(answer));
}

}  // namespace tactbench::tests
