// Files inside a PDF, with what they are to it: PDF 1.7 with associated files as ISO 32000-2, 14.13, describes them. It
// is not PDF/A-3, which asks for more.
#pragma once

#include <string>
#include <vector>

namespace tactbench::bench {

struct PdfAttachment {
  std::string name, mime, description, bytes;
};

// The PDF with these attached as its data (/AFRelationship /Data). Same input, same bytes.
// Throws Error TB-REPORT-PDF for what is no PDF.
std::string with_attachments(const std::string& pdf, std::vector<PdfAttachment> attachments);

}  // namespace tactbench::bench
