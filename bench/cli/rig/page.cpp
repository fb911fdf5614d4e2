// page: shows the bench in a browser. A separate process, which holds no instrument.
#include "bench/cli/rig/page.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <charconv>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "bench/cli/rig/control.h"
#include "bench/cli/session.h"
#include "bench/common/child_process.h"
#include "bench/common/private_files.h"
#include "bench/common/stop_request.h"
#include "bench/config/config.h"
#include "bench/config/config_laboratory.h"
#include "bench/page/access.h"
#include "bench/page/page_server.h"

namespace tactbench::bench {

namespace {

constexpr std::uint16_t kUsualPort = 8765;

struct PageVerbOptions {
  PageOptions page;
  std::string lab;
  std::vector<std::string> tls;
  bool port_given = false;
};

bool is_loopback(const std::string& address) { return address.starts_with("127.") || address == "::1"; }

// ADDRESS:PORT and [ADDRESS]:PORT. The server refuses any other text.
void split_port(PageVerbOptions& options) {
  std::string& address = options.page.http.address;
  const bool bracketed = address.starts_with('[');
  const std::size_t colon = bracketed ? address.find("]:") + 1 : address.find(':');
  if (colon == 0 || colon == std::string::npos || (!bracketed && colon != address.rfind(':'))) return;
  const char* const end = address.data() + address.size();
  const auto read = std::from_chars(address.data() + colon + 1, end, options.page.http.port);
  if (read.ec != std::errc() || read.ptr != end) return;
  options.port_given = true;
  address = bracketed ? address.substr(1, colon - 2) : address.substr(0, colon);
}

// The command that makes a self-signed certificate: a browser asks once whether to trust it.
std::string certificate_command(const std::string& address) {
  const bool any = address == "0.0.0.0" || address == "::";
  const std::vector<std::string> own = any ? own_addresses(address == "::") : std::vector<std::string>{address};
  return fmt::format(
      "openssl req -x509 -newkey rsa:2048 -nodes -days 365 -subj /CN=tactbench "
      "-addext subjectAltName=DNS:localhost{}{} -keyout page-key.pem -out page.pem",
      own.empty() ? "" : ",IP:", fmt::join(own, ",IP:"));
}

void check(PageVerbOptions& options) {
  PageOptions& page = options.page;
  split_port(options);
  if (!page.operator_name.empty()) check_operator(page.operator_name);
  if (!page.night.empty() && !std::filesystem::is_regular_file(page.night)) {
    throw Error("TB-FILE-MISSING", "there is no such file", page.night,
                "name the page that `tactbench nightly --html` wrote");
  }
  if (!options.lab.empty()) page.laboratory = read_laboratory(find_config(options.lab));
  if (!options.tls.empty()) {
    page.http.certificate = options.tls[0];
    page.http.key = options.tls[1];
  } else if (!is_loopback(page.http.address)) {
    throw Error("TB-PAGE-OPEN",
                fmt::format("on {} everybody on the network could read the keys in the link", page.http.address),
                "--listen " + page.http.address,
                fmt::format("make a certificate: {0}; then add --tls page.pem page-key.pem; or leave --listen out and "
                            "connect through a tunnel: ssh -L {1}:127.0.0.1:{1} THIS-MACHINE",
                            certificate_command(page.http.address), page.http.port));
  }
}

// If another page uses the default port, any free one is used; the link shows it.
std::unique_ptr<PageServer> open_server(const PageVerbOptions& options) {
  try {
    return std::make_unique<PageServer>(options.page);
  } catch (const Error& error) {
    if (options.port_given || !error.id().ends_with("PAGE-ADDRESS")) throw;
    PageOptions other = options.page;
    other.http.port = 0;
    return std::make_unique<PageServer>(other);
  }
}

// Next to a run, its streams are closed: otherwise a process that reads them would also wait for this one.
void leave_streams() {
  const int null = ::open("/dev/null", O_RDWR | O_CLOEXEC);
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (null >= 0) (void)::dup2(null, stream);
}

void announce(const PageServer& server, const PageOptions& page, const Session& session) {
  if (session.json) {
    print_json("page", {{"link", server.link()},
                        {"readers_link", server.readers_link()},
                        {"links", server.links()},
                        {"readers_links", server.readers_links()},
                        {"operator", page.operator_name},
                        {"port", server.port()}});
  } else {
    std::FILE* const out = page.run_process != 0 ? stderr : stdout;
    for (const std::string& link : server.links()) tty::print(out, "page: {}\n", link);
    if (page.operator_name.empty()) return;
    for (const std::string& link : server.readers_links()) tty::print(out, "to watch only: {}\n", link);
  }
}

void serve(PageVerbOptions& options, const Session& session) {
  check(options);
  const StopRequest stop;
  options.page.db = session.db;
  options.page.bench = bench_id_of(options.page.bench);
  const std::unique_ptr<PageServer> server = open_server(options);
  announce(*server, options.page, session);
  (void)std::fflush(stdout);
  if (options.page.run_process != 0) leave_streams();
  server->serve([&stop] { return stop.signal() != 0; });
}

}  // namespace

void add_page(CLI::App& app, Session& session) {
  auto options = std::make_shared<PageVerbOptions>();
  PageOptions& page = options->page;
  page.http.port = kUsualPort;
  CLI::App* verb = app.add_subcommand("page",
                                      "show the bench in a browser: prints an address, serves it until Ctrl-C\n"
                                      "A separate process that reads the store and follows the live run; a run never "
                                      "waits for it.");
  session.profile.add(*verb, "--operator", ProfileKey::kOperator, page.operator_name,
                      "name of the person who commands from the page: anyone with the address may then pause, resume, "
                      "stop, abort, panic and answer prompts under this name; without it the page is read-only");
  verb->add_option_function<std::uint16_t>(
          "--port",
          [options](std::uint16_t port) {
            options->page.http.port = port;
            options->port_given = true;
          },
          "port; 0: any free one")
      ->default_str(std::to_string(kUsualPort));
  verb->add_option("--listen", page.http.address,
                   "address of this machine to listen on, with a port or without; any except loopback needs --tls; "
                   "0.0.0.0: all addresses; the links for other machines, such as a phone, are then printed")
      ->capture_default_str();
  verb->add_option("--tls", options->tls, "certificate chain and private key, files in PEM")
      ->type_name("CERTIFICATE KEY")
      ->expected(2);
  verb->add_option("--name", page.names, "further names under which browsers may reach it, without the port")
      ->take_all();
  verb->add_option("--night", page.night, "page that `nightly --html` wrote, shown in the view of the nights");
  session.profile.add(*verb, "--lab", ProfileKey::kLab, options->lab,
                      "laboratory file: until when a calibration is valid");
  verb->add_option("--run-process", page.run_process,
                   "process of a run: the page ends once that has ended and nobody views the page")
      ->group("");
  for (const char* const name : {"--listen", "--tls", "--name", "--night"}) verb->get_option(name)->group(kRareOptions);
  verb->callback([options, &session] {
    options->page.bench = session.typed_bench();
    serve(*options, session);
  });
}

void start_background_page(const std::string& db, const std::string& bench_id, const std::string& operator_name) {
  std::vector<std::string> arguments = {"/proc/self/exe", "page",   "--db",          db,
                                        "--bench",        bench_id, "--run-process", std::to_string(::getpid())};
  if (!operator_name.empty()) arguments.push_back("--operator=" + operator_name);
  ChildProgram page({.arguments = arguments, .environment = environment_with({})});
  page.let_go();
}

}  // namespace tactbench::bench
