// Files that verbs write on request. Without --replace an existing file is replaced only by one of the same kind; a
// store or a signed report is never replaced.
#pragma once

#include <cstddef>
#include <functional>
#include <iosfwd>
#include <string>

namespace tactbench::bench {

// The kind of a file, recognised by its beginning: "a page of tactbench (HTML)", "a tactbench.model document (JSON)",
// "frames of a run (CSV)", "a table (CSV) with the columns ...", "an SQLite database (a store, perhaps)", ...
std::string kind_of_file(const std::string& beginning);

// Kinds that a verb can name before it makes the text.
inline constexpr const char* kPageFile = "a page of tactbench (HTML)";
inline constexpr const char* kPdfFile = "a PDF";
inline constexpr const char* kDccFile = "a digital calibration certificate (XML)";
inline constexpr const char* kSvgFile = "a chart of tactbench (SVG)";
inline constexpr const char* kRunTable = "frames of a run (CSV)";
inline constexpr const char* kRunDocument = "a tactbench.run document (JSON)";
inline constexpr const char* kModelFile = "a tactbench.model document (JSON)";
inline constexpr const char* kScenarioLogFile = "the output of a night's scenario";
inline constexpr const char* kScenarioLogHead = "# Talk of tactbench nightly, scenario ";  // first line of such a file

// Throws Error TB-FILE-STORE when `path` is an SQLite database, its log or its lock, also through a link,
// TB-REPORT-SIGNED when it is a signed report, and TB-FILE-EXISTS when it is a file of another kind than `kind` and may
// not be replaced. Accepts a missing or empty file, a device and a pipe. For verbs that compute for long before they
// write.
void check_output(const std::string& path, const std::string& kind, bool replace);

// Checks, then writes: replaces a file at once (a reader never sees half of it), follows a link, and makes the folder
// if needed; a device or pipe is written to directly. Also throws Error TB-FILE-WRITE.
void write_output(const std::string& path, const std::string& text, bool replace);
// The same for text that `write` streams because it is too long for memory; returns the number of bytes.
using WriteOutput = std::function<void(std::ostream&)>;
std::size_t write_output(const std::string& path, const std::string& kind, const WriteOutput& write, bool replace);

// Replaces the file at once, whatever its kind: for the program's own files. Makes the folder. Throws Error
// TB-FILE-WRITE.
void write_whole(const std::string& path, const std::string& text);

// Finds the number of a signed report in the data that its page or JSON document contains.
// Number of the signed report in a page or JSON document, from its data; empty: not a signed report.
std::string signed_report_number_in(const std::string& text);

}  // namespace tactbench::bench
