// HTTP responses of the page: which path needs which right, the page's own files, and the header fields that every
// response carries.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "bench/page/access.h"
#include "bench/page/http/message.h"

namespace tactbench::bench {

inline constexpr const char* kDocumentPath = "/document/";

// None: there is no such path.
std::optional<PageNeeds> needs_of(const std::string& path);
// One of the page's own files; none: the path is not one of them.
std::optional<HttpResponse> page_asset(const std::string& path);
HttpResponse json_response(int status, const nlohmann::ordered_json& json);
// A page that another verb wrote, shown in a frame: it has its own style and no script.
HttpResponse document_response(const std::string& text);
// Adds the header fields that isolate the page in the browser.
HttpResponse guarded(HttpResponse response);
// A server-sent event.
SharedText event_text(const std::string& name, const nlohmann::json& json);
// A number of the query; `fallback` if it is missing or not a number.
std::int64_t number_in(const HttpRequest& request, const std::string& name, std::int64_t fallback = 0);

}  // namespace tactbench::bench
