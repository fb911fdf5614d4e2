#include "bench/page/responses.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <nlohmann/json.hpp>
#include <string_view>

#include "analysis/json_io.h"
#include "bench/page/assets.h"

namespace tactbench::bench {

namespace {

constexpr std::array<std::array<std::string_view, 2>, 4> kTypes = {{{".html", "text/html; charset=utf-8"},
                                                                    {".css", "text/css; charset=utf-8"},
                                                                    {".js", "text/javascript; charset=utf-8"},
                                                                    {".svg", "image/svg+xml"}}};
constexpr std::array<std::string_view, 9> kReadPlaces = {"/events",      "/loop",        "/runs",
                                                         "/sensors",     "/make/report", "/make/compare",
                                                         "/make/sensor", "/make/nights", "/make/night"};

// The page runs only its own script and style, connects only to this server, and cannot be framed.
constexpr const char* kPagePolicy =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; connect-src 'self'; frame-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
// A document contains its style; it has no script and makes no connections.
constexpr const char* kDocumentPolicy =
    "default-src 'none'; style-src 'unsafe-inline'; img-src data:; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'self'; sandbox allow-popups";
constexpr const char* kPolicyField = "Content-Security-Policy";

}  // namespace

std::optional<PageNeeds> needs_of(const std::string& path) {
  if (page_asset(path)) return PageNeeds::kNothing;
  if (path.starts_with(kDocumentPath)) return PageNeeds::kNothing;  // its name is the secret
  if (path == "/command") return PageNeeds::kCommand;
  if (std::ranges::find(kReadPlaces, path) != kReadPlaces.end()) return PageNeeds::kRead;
  return std::nullopt;
}

std::optional<HttpResponse> page_asset(const std::string& path) {
  const std::string name = path == "/" ? "page.html" : path.substr(std::min<std::size_t>(path.size(), 1));
  const std::string_view bytes = asset(name);
  if (bytes.empty()) return std::nullopt;
  const auto* const type = std::ranges::find_if(kTypes, [&](const auto& one) { return name.ends_with(one[0]); });
  return HttpResponse{.type = std::string((*type)[1]), .body = std::make_shared<const std::string>(bytes)};
}

HttpResponse json_response(int status, const nlohmann::ordered_json& json) {
  return {.status = status,
          .type = "application/json",
          .body = std::make_shared<const std::string>(analysis::printable_json(json))};
}

HttpResponse document_response(const std::string& text) {
  return {.type = "text/html; charset=utf-8",
          .body = std::make_shared<const std::string>(text),
          .fields = {{kPolicyField, kDocumentPolicy}}};
}

HttpResponse guarded(HttpResponse response) {
  const bool own_policy =
      std::ranges::any_of(response.fields, [](const auto& field) { return field.first == kPolicyField; });
  if (!own_policy) response.fields.emplace_back(kPolicyField, kPagePolicy);
  for (const auto& [name, value] :
       {std::pair{"X-Content-Type-Options", "nosniff"}, std::pair{"Referrer-Policy", "no-referrer"},
        std::pair{"Cache-Control", "no-store"}, std::pair{"Cross-Origin-Resource-Policy", "same-origin"},
        std::pair{"Cross-Origin-Opener-Policy", "same-origin"}})
    response.fields.emplace_back(name, value);
  return response;
}

SharedText event_text(const std::string& name, const nlohmann::json& json) {
  return std::make_shared<const std::string>(
      fmt::format("event: {}\ndata: {}\n\n", name, analysis::printable_json(json)));
}

std::int64_t number_in(const HttpRequest& request, const std::string& name, std::int64_t fallback) {
  const auto found = request.query.find(name);
  if (found == request.query.end()) return fallback;
  const std::string& text = found->second;
  std::int64_t number = 0;
  const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), number);
  return failed == std::errc() && end == text.data() + text.size() ? number : fallback;
}

}  // namespace tactbench::bench
