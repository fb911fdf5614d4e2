// Attaches files to a PDF: PDF 1.7 with associated files according to ISO 32000-2, 14.13. The result is not PDF/A-3,
// which has further requirements.
#pragma once

#include <string>
#include <vector>

namespace tactbench::bench {

struct PdfAttachment {
  std::string name, mime, description, bytes;
};

// The PDF with the files attached as its data (/AFRelationship /Data). The same input gives the same bytes. Throws
// Error TB-REPORT-PDF if `pdf` is not a PDF.
std::string with_attachments(const std::string& pdf, std::vector<PdfAttachment> attachments);

}  // namespace tactbench::bench
