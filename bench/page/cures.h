// What to do about an error that a run's events name: from the same table that the documentation prints.
#pragma once

#include <map>
#include <string>
#include <string_view>

namespace tactbench::bench {

// `table`: docs/reference-errors.md. By identifier: what it advises, the first piece of advice where there are several
// cases. Parts that depend on the case are the table's dots.
std::map<std::string, std::string, std::less<>> cures_of(std::string_view table);
// Of the program's own table; empty where it has none.
std::string cure_of(std::string_view id);

}  // namespace tactbench::bench
