// Converts a report's HTML to PDF with an installed browser or typesetter.
#pragma once

#include <string>
#include <vector>

#include "bench/reporting/pdf_attachments.h"

namespace tactbench::bench {

struct PdfRequest {
  std::string html;
  std::vector<PdfAttachment> attachments;
  std::string path;      // of the PDF; written whole
  std::string program;   // chromium | weasyprint; empty: the first of them that is there
  std::string date_utc;  // for the document's dates: the same report is the same bytes
  std::string run_uuid;  // in the document's title: nothing else of a PDF can be read without a PDF's reader
  bool replace = false;  // a file of another kind (output_file.h)
};

// Runs the program in a new folder of its own and waits 120 s at most. Returns the program used. Throws Error
// TB-REPORT-PDF (names the packages when none is installed; includes the program's message when it failed).
std::string write_pdf(const PdfRequest& request);

}  // namespace tactbench::bench
