#include "bench/page/http/connection.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/post.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/string_body.hpp>

namespace tactbench::bench {

namespace http = boost::beast::http;
using boost::asio::buffer;
using boost::asio::ip::tcp;
using boost::system::error_code;

namespace {

constexpr int kUnsentBytes =
    16 * 1024;  // kernel buffer for a viewer's events; a larger one would give a stopped viewer outdated events

constexpr std::chrono::milliseconds kParting{1000};
constexpr std::size_t kMostDropped = 256 * 1024;

std::string text_of(boost::beast::string_view view) { return {view.data(), view.size()}; }

}  // namespace

class Connection::Parser : public http::request_parser<http::string_body> {};

Connection::Connection(ConnectionHost& host, std::unique_ptr<Wire> wire, boost::asio::io_context& context)
    : host_(host), wire_(std::move(wire)), deadline_(context) {}

Connection::~Connection() {
  if (viewer_) --host_.viewers;
}

void Connection::start() {
  arm(host_.options.request_timeout);
  wire_->open([self = shared_from_this()](bool ok, std::size_t) { ok ? self->expect_request() : self->close(); });
}

void Connection::close() {
  if (closed_) return;
  closed_ = true;
  deadline_.cancel();
  waiting_.clear();
  error_code ignored;
  wire_->socket().shutdown(tcp::socket::shutdown_both, ignored);
  wire_->socket().close(ignored);
}

void Connection::arm(std::chrono::milliseconds longest) {
  deadline_.expires_after(longest);
  deadline_.async_wait([weak = weak_from_this()](const error_code& error) {
    if (error) return;
    if (const auto self = weak.lock()) self->close();
  });
}

void Connection::expect_request() {
  parser_ = std::make_unique<Parser>();
  parser_->eager(true);
  parser_->header_limit(static_cast<std::uint32_t>(host_.options.max_head_bytes));
  parser_->body_limit(host_.options.max_body_bytes);
  arm(host_.options.request_timeout);
  unread_.empty() ? read_more() : take_bytes();
}

void Connection::read_more() {
  wire_->read(bytes_.data(), bytes_.size(), [self = shared_from_this()](bool ok, std::size_t size) {
    if (self->closed_) return;
    if (!ok) return self->close();
    self->unread_.append(self->bytes_.data(), size);
    self->take_bytes();
  });
}

void Connection::take_bytes() {
  error_code error;
  const std::size_t taken = parser_->put(buffer(unread_), error);
  unread_.erase(0, taken);
  if (error == http::error::header_limit ||
      (!parser_->is_header_done() && unread_.size() > host_.options.max_head_bytes))
    return refuse(431, "the request's header is too long\n");
  if (error == http::error::body_limit) return refuse(413, "the request's body is too long\n");
  if (error && error != http::error::need_more) return refuse(400, "this is not a request\n");
  parser_->is_done() ? handle() : read_more();
}

void Connection::refuse(int status, const std::string& text) { answer(text_response(status, text), false); }

void Connection::handle() {
  deadline_.cancel();  // an answer may take its time: a report is computed
  const auto& message = parser_->get();
  HttpRequest request;
  request.method = text_of(message.method_string());
  read_target(text_of(message.target()), request);
  for (const auto& field : message) {
    std::string& text = request.fields[lower_case(text_of(field.name_string()))];
    text += (text.empty() ? "" : ", ") + text_of(field.value());
  }
  request.body = message.body();
  error_code ignored;
  request.from = wire_->socket().remote_endpoint(ignored).address().to_string();
  if (host_.rank) rank_ = std::max(rank_, host_.rank(request));
  const bool goes_on = message.keep_alive();
  host_.handler(request, [self = shared_from_this(), goes_on](HttpResponse response) {
    if (!self->closed_) self->answer(std::move(response), goes_on);
  });
}

void Connection::answer(HttpResponse response, bool goes_on) {
  if (response.stream && host_.viewers >= host_.options.max_viewers) {
    response = text_response(503, fmt::format("there are already {} viewers\n", host_.viewers));
    response.fields.emplace_back("Retry-After", "10");
  }
  const bool stream = response.stream;
  goes_on = goes_on && !stream;
  body_ = std::move(response.body);
  head_ = fmt::format("HTTP/1.1 {} {}\r\nContent-Type: {}\r\nConnection: {}\r\n", response.status,
                      text_of(http::obsolete_reason(static_cast<http::status>(response.status))), response.type,
                      goes_on ? "keep-alive" : "close");
  if (!stream) head_ += fmt::format("Content-Length: {}\r\n", body_ ? body_->size() : 0);
  for (const auto& [name, value] : response.fields) head_ += fmt::format("{}: {}\r\n", name, value);
  head_ += "\r\n";
  std::vector<boost::asio::const_buffer> parts{buffer(head_)};
  if (body_) parts.push_back(buffer(*body_));
  if (stream) become_viewer();
  arm(host_.options.longest_write);
  writing_ = true;
  wire_->write(parts, [self = shared_from_this(), goes_on, stream](bool ok, std::size_t) {
    self->writing_ = false;
    self->body_.reset();
    if (self->closed_) return;
    if (!ok) return self->close();
    self->deadline_.cancel();
    if (stream) {
      self->watch_for_end();
      self->write_events();
    } else if (goes_on) {
      self->expect_request();
    } else {
      self->part();
    }
  });
}

// A client that still sends would lose the answer if the connection broke off now.
void Connection::part() {
  error_code ignored;
  wire_->socket().shutdown(tcp::socket::shutdown_send, ignored);
  arm(kParting);
  drop_the_rest();
}

void Connection::drop_the_rest() {
  wire_->read(bytes_.data(), bytes_.size(), [self = shared_from_this()](bool ok, std::size_t size) {
    if (self->closed_) return;
    self->dropped_ += size;
    ok && self->dropped_ < kMostDropped ? self->drop_the_rest() : self->close();
  });
}

void Connection::become_viewer() {
  viewer_ = true;
  ++host_.viewers;
  error_code ignored;
  wire_->socket().set_option(tcp::socket::send_buffer_size(kUnsentBytes), ignored);
  wire_->socket().set_option(tcp::no_delay(true), ignored);
}

// A viewer sends nothing more; data from it are dropped, and its disconnection is detected.
void Connection::watch_for_end() {
  wire_->read(bytes_.data(), bytes_.size(), [self = shared_from_this()](bool ok, std::size_t) {
    if (self->closed_) return;
    ok ? self->watch_for_end() : self->close();
  });
}

void Connection::offer(int kind, const SharedText& event) {
  if (closed_ || !viewer_) return;
  const auto older = std::ranges::find(waiting_, kind, &std::pair<int, SharedText>::first);
  if (older != waiting_.end()) {
    older->second = event;
    ++host_.skipped;
  } else {
    waiting_.emplace_back(kind, event);
  }
  if (writing_ || due_) return;
  due_ = true;  // events offered in the same turn are sent together
  boost::asio::post(deadline_.get_executor(), [self = shared_from_this()] {
    self->due_ = false;
    if (!self->writing_) self->write_events();
  });
}

void Connection::write_events() {
  if (closed_ || waiting_.empty()) return;
  sent_ = std::move(waiting_);
  waiting_.clear();
  std::vector<boost::asio::const_buffer> parts;
  parts.reserve(sent_.size());
  for (const auto& [kind, event] : sent_) parts.push_back(buffer(*event));
  writing_ = true;
  arm(host_.options.longest_write);
  wire_->write(parts, [self = shared_from_this()](bool ok, std::size_t) {
    self->writing_ = false;
    if (self->closed_) return;
    if (!ok) return self->close();
    self->deadline_.cancel();
    self->write_events();
  });
}

}  // namespace tactbench::bench
