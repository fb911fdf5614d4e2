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

struct OwnFile {
  std::string_view path, name, type;
};
constexpr std::array kOwnFiles = {
    OwnFile{"/", "page.html", "text/html; charset=utf-8"},
    OwnFile{"/page.css", "page.css", "text/css; charset=utf-8"},
    OwnFile{"/page.js", "page.js", "text/javascript; charset=utf-8"},
    OwnFile{"/link.js", "link.js", "text/javascript; charset=utf-8"},
    OwnFile{"/draw.js", "draw.js", "text/javascript; charset=utf-8"},
    OwnFile{"/now.js", "now.js", "text/javascript; charset=utf-8"},
    OwnFile{"/panels.js", "panels.js", "text/javascript; charset=utf-8"},
    OwnFile{"/seen.js", "seen.js", "text/javascript; charset=utf-8"},
    OwnFile{"/store.js", "store.js", "text/javascript; charset=utf-8"},
    OwnFile{"/icon.svg", "icon.svg", "image/svg+xml"},
};
constexpr std::array<std::string_view, 9> kReadPlaces = {"/events",      "/loop",        "/runs",
                                                         "/sensors",     "/make/report", "/make/compare",
                                                         "/make/sensor", "/make/nights", "/make/night"};

// The page runs its own script and style alone, talks to this server alone, and nobody frames it.
constexpr const char* kPagePolicy =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; connect-src 'self'; frame-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
// A document brings its style in itself; it has no script and talks to nobody.
constexpr const char* kDocumentPolicy =
    "default-src 'none'; style-src 'unsafe-inline'; img-src data:; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'self'; sandbox allow-popups";
constexpr const char* kPolicyField = "Content-Security-Policy";

}  // namespace

std::optional<PageNeeds> needs_of(const std::string& path) {
  if (std::ranges::find(kOwnFiles, path, &OwnFile::path) != kOwnFiles.end()) return PageNeeds::kNothing;
  if (path.starts_with(kDocumentPath)) return PageNeeds::kNothing;  // its name is the secret
  if (path == "/command") return PageNeeds::kCommand;
  if (std::ranges::find(kReadPlaces, path) != kReadPlaces.end()) return PageNeeds::kRead;
  return std::nullopt;
}

std::optional<HttpResponse> own_file(const std::string& path) {
  const auto file = std::ranges::find(kOwnFiles, path, &OwnFile::path);
  if (file == kOwnFiles.end()) return std::nullopt;
  return HttpResponse{.type = std::string(file->type), .body = std::make_shared<const std::string>(asset(file->name))};
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
