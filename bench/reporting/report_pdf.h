// Converts a report's HTML to PDF with an installed browser or typesetter, and attaches files to a PDF.
#pragma once

#include <string>
#include <vector>

namespace tactbench::bench {

// Attaches files to a PDF: PDF 1.7 with associated files according to ISO 32000-2, 14.13. The result is not PDF/A-3,
// which has further requirements.
struct PdfAttachment {
  std::string name, mime, description, bytes;
};

// The PDF with the files attached as its data (/AFRelationship /Data). The same input gives the same bytes. Throws
// Error TB-REPORT-PDF if `pdf` is not a PDF.
std::string with_attachments(const std::string& pdf, std::vector<PdfAttachment> attachments);

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
