// Files that verbs write on request. What lies there already is replaced only by its like: a store never is, another
// kind of file only with --replace.
#pragma once

#include <cstddef>
#include <functional>
#include <iosfwd>
#include <string>

namespace tactbench::bench {

// What a file is, by how it begins: "a page of tactbench (HTML)", "a tactbench.model document (JSON)",
// "frames of a run (CSV)", "a table (CSV) with the columns ...", "an SQLite database (a store, perhaps)", ...
std::string kind_of_file(const std::string& beginning);

// Kinds that verbs know before they have the text.
inline constexpr const char* kPageFile = "a page of tactbench (HTML)";
inline constexpr const char* kPdfFile = "a PDF";
inline constexpr const char* kHdf5File = "an HDF5 file";
inline constexpr const char* kRunTable = "frames of a run (CSV)";
inline constexpr const char* kRunDocument = "a tactbench.run document (JSON)";
inline constexpr const char* kModelFile = "a tactbench.model document (JSON)";
inline constexpr const char* kTalkFile = "the talk of a night's scenario";
inline constexpr const char* kTalkHead = "# Talk of tactbench nightly, scenario ";  // how it begins

// Throws Error TB-FILE-STORE when `path` is an SQLite database, its log or its lock, also through a link,
// TB-REPORT-SIGNED when it is a signed report, and TB-FILE-EXISTS when it is a file of another kind than `kind` and may
// not be replaced. Passes what is not there, is empty, or is no file but a
// device or a pipe. For verbs that work long before they write.
void check_output(const std::string& path, const std::string& kind, bool replace);

// Checks, then writes: a file whole (a reader never sees half of it) in the place of what a link leads to, with its
// folder if need be; into a device or pipe as it comes. Throws Error TB-FILE-WRITE, too.
void write_output(const std::string& path, const std::string& text, bool replace);
// The same of what `write` streams, for what is too long to be held at once; returns how many bytes.
using WriteOutput = std::function<void(std::ostream&)>;
std::size_t write_output(const std::string& path, const std::string& kind, const WriteOutput& write, bool replace);

// A new, empty file beside the one that `path` means, for a library that writes under a name; to be renamed to it.
struct HalfFile {
  std::string name;    // with the rights of the file that it is going to replace
  std::string target;  // where a link at `path` leads to
};
// Throws Error TB-FILE-WRITE, also where `path` is a pipe or a device.
HalfFile make_half_file(const std::string& path);

// Writes a file whole whatever lies there: for files of our own. Makes the folder. Throws Error TB-FILE-WRITE.
void write_whole(const std::string& path, const std::string& text);

}  // namespace tactbench::bench
