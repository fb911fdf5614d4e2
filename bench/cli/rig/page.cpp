// page: what the bench does, in a browser. A process of its own, which holds no instrument.
#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "bench/cli/rig/named_run.h"
#include "bench/cli/rig/page_beside.h"
#include "bench/cli/session.h"
#include "bench/common/child_process.h"
#include "bench/common/private_files.h"
#include "bench/common/stop_request.h"
#include "bench/config/config.h"
#include "bench/config/config_laboratory.h"
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

void check(PageVerbOptions& options) {
  PageOptions& page = options.page;
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
    throw Error(
        "TB-PAGE-OPEN",
        fmt::format("on {} everybody on the network could read the link's keys on their way", page.http.address),
        "--listen " + page.http.address);
  }
}

// The usual port may be another page's: then any free one, which the link names.
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

// Beside a run nothing of its streams is kept: who reads them would wait for this process, too.
void leave_streams() {
  const int null = ::open("/dev/null", O_RDWR | O_CLOEXEC);
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (null >= 0) (void)::dup2(null, stream);
}

void announce(const PageServer& server, const PageOptions& page, const Session& session) {
  if (session.json) {
    print_json("page", {{"link", server.link()},
                        {"readers_link", server.readers_link()},
                        {"operator", page.operator_name},
                        {"port", server.port()}});
  } else {
    std::FILE* const out = page.beside != 0 ? stderr : stdout;
    tty::print(out, "page: {}\n", server.link());
    if (server.readers_link() != server.link()) tty::print(out, "to watch only: {}\n", server.readers_link());
  }
  (void)std::fflush(stdout);
}

void serve(PageVerbOptions& options, const Session& session) {
  check(options);
  const StopRequest stop;
  options.page.db = session.db;
  options.page.bench = bench_id_of(options.page.bench);
  const std::unique_ptr<PageServer> server = open_server(options);
  announce(*server, options.page, session);
  if (options.page.beside != 0) leave_streams();
  server->serve([&stop] { return stop.signal() != 0; });
}

}  // namespace

void add_page(CLI::App& app, Session& session) {
  auto options = std::make_shared<PageVerbOptions>();
  PageOptions& page = options->page;
  page.http.port = kUsualPort;
  CLI::App* verb = app.add_subcommand("page",
                                      "the bench in a browser: prints an address, serves it until Ctrl-C\n"
                                      "A process of its own that reads the store and follows the live run; a run never "
                                      "waits for it.");
  session.profile.add(*verb, "--operator", ProfileKey::kOperator, page.operator_name,
                      "who commands from the page: the address then lets its holder pause, resume, stop, abort, panic "
                      "and answer prompts under this name; without it the page only shows");
  verb->add_option_function<std::uint16_t>(
          "--port",
          [options](std::uint16_t port) {
            options->page.http.port = port;
            options->port_given = true;
          },
          "port; 0 takes a free one")
      ->default_str(std::to_string(kUsualPort));
  verb->add_option("--listen", page.http.address, "address of this machine to listen on; any but loopback needs --tls")
      ->capture_default_str();
  verb->add_option("--tls", options->tls, "certificate chain and private key, files in PEM")
      ->type_name("CERTIFICATE KEY")
      ->expected(2);
  verb->add_option("--name", page.names, "further names under which browsers may reach it, without the port")
      ->take_all();
  verb->add_option("--night", page.night, "page that `nightly --html` wrote, shown in the view of the nights");
  session.profile.add(*verb, "--lab", ProfileKey::kLab, options->lab,
                      "laboratory file: until when a calibration counts");
  verb->add_option("--beside", page.beside, "process of a run: ends once that has ended and nobody looks")->group("");
  for (const char* const name : {"--listen", "--tls", "--name", "--night"}) verb->get_option(name)->group(kRareOptions);
  verb->callback([options, &session] {
    options->page.bench = session.typed_bench();
    serve(*options, session);
  });
}

void start_page_beside(const std::string& db, const std::string& bench_id, const std::string& operator_name) {
  std::vector<std::string> words = {"/proc/self/exe", "page",   "--db",     db,
                                    "--bench",        bench_id, "--beside", std::to_string(::getpid())};
  if (!operator_name.empty()) words.push_back("--operator=" + operator_name);
  ChildProgram page({.words = words, .environment = environment_with({})});
  page.let_go();
}

}  // namespace tactbench::bench
