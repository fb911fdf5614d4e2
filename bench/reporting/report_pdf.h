// Converts a report's HTML to PDF with an installed browser or typesetter.
#pragma once

#include <string>
#include <vector>

#include "bench/reporting/pdf_attachments.h"

namespace tactbench::bench {

struct PdfRequest {
  std::string html;
  std::vector<PdfAttachment> attachments;
  std::string path;      // path of the PDF, which is written atomically
  std::string program;   // chromium | weasyprint; empty: the first that is installed
  std::string date_utc;  // for the document's dates, so that the same report gives the same bytes
  std::string run_uuid;  // part of the document's title, which can be found without a PDF reader
  bool replace = false;  // also replaces a file of another kind (output_file.h)
};

// Runs the program in a new temporary folder and waits at most 120 s. Returns the program used. Throws Error
// TB-REPORT-PDF (names the packages when none is installed; includes the program's message when it failed).
std::string write_pdf(const PdfRequest& request);

}  // namespace tactbench::bench
