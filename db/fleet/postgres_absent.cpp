// Without libpq: the verbs of the fleet say so.
#ifndef TACTBENCH_HAVE_LIBPQ

#include "db/fleet/postgres.h"

namespace tactbench::db::fleet {

namespace {
[[noreturn]] void not_built() {
  throw FleetError(FleetCause::kUsage, "TB-FLEET-BUILD", "this program was built without libpq and knows no fleet",
                   "install libpq-dev, then configure and build again");
}
}  // namespace

struct Link::State {
  std::string where, user;
};
Link::Link(const std::string&, std::chrono::seconds, std::chrono::seconds) { not_built(); }
Link::~Link() = default;
std::vector<TextRow> Link::query(const std::string&, const std::vector<std::string>&) { not_built(); }
void Link::execute(const std::string&) { not_built(); }
void Link::copy_in(const std::string&, const std::function<bool(std::string&)>&) { not_built(); }
void Link::copy_out(const std::string&, const std::function<void(std::string_view)>&) { not_built(); }
const std::string& Link::where() const { return state_->where; }
const std::string& Link::user() const { return state_->user; }
std::string where_of(const std::string&) { not_built(); }
bool built_with_libpq() { return false; }
std::string libpq_version() { return {}; }
Transaction::Transaction(Link& link, const char*) : link_(link) {}
Transaction::~Transaction() = default;
void Transaction::commit() { open_ = false; }

}  // namespace tactbench::db::fleet

#endif
