// Files attached to a PDF: found by a PDF's reader, byte for byte, with what they are to it; the same bytes each time.
#include "bench/reporting/report_pdf.h"

#include <qpdf/qpdf-c.h>

#include <catch2/catch.hpp>
#include <cstdlib>

#include "bench/common/error.h"

using namespace tactbench::bench;

namespace {

// One empty page; `names`: of the catalogue.
std::string small_pdf(const std::string& names) {
  return "%PDF-1.4\n1 0 obj <</Type/Catalog/Pages 2 0 R" + names +
         ">> endobj\n2 0 obj <</Type/Pages/Kids[3 0 R]/Count 1>> endobj\n3 0 obj <</Type/Page/Parent 2 0 R/MediaBox[0 "
         "0 9 9]>> endobj\ntrailer <</Size 4/Root 1 0 R/Info<</Title(1-2ccd46bc, signed)>>>>\n%%EOF\n";
}

struct ReadPdf {
  explicit ReadPdf(const std::string& bytes) {
    qpdf_silence_errors(data);
    (void)qpdf_read_memory(data, "test", bytes.data(), bytes.size(), nullptr);
    REQUIRE(qpdf_has_error(data) == QPDF_FALSE);
  }
  ~ReadPdf() { qpdf_cleanup(&data); }
  ReadPdf(const ReadPdf&) = delete;
  ReadPdf& operator=(const ReadPdf&) = delete;
  [[nodiscard]] qpdf_oh at(qpdf_oh from, const std::vector<std::string>& keys) const {
    for (const std::string& key : keys) from = qpdf_oh_get_key(data, from, key.c_str());
    return from;
  }
  [[nodiscard]] std::string text(qpdf_oh from, const char* key) const {
    const qpdf_oh value = qpdf_oh_get_key(data, from, key);
    return qpdf_oh_is_name(data, value) == QPDF_TRUE ? qpdf_oh_get_name(data, value)
                                                     : qpdf_oh_get_utf8_value(data, value);
  }
  [[nodiscard]] std::string content(qpdf_oh file) const {
    unsigned char* bytes = nullptr;
    std::size_t size = 0;
    QPDF_BOOL filtered = QPDF_FALSE;
    (void)qpdf_oh_get_stream_data(data, at(file, {"/EF", "/F"}), qpdf_dl_generalized, &filtered, &bytes, &size);
    std::string text(reinterpret_cast<const char*>(bytes), size);
    std::free(bytes);
    return text;
  }
  qpdf_data data = qpdf_init();
};

}  // namespace

TEST_CASE("files attached to a PDF are read back, by name and as its associated data, in either order") {
  const PdfAttachment json{"report.json", "application/json", "all data", "{\"a\":1}\n"};
  const PdfAttachment xml{"certificate.xml", "application/xml", "ärgerlich",
                          std::string(70000, 'x') + std::string(1, '\0')};
  for (const char* names : {"", "/Names<</Dests<<>>>>"}) {
    const std::string made = with_attachments(small_pdf(names), {json, xml});
    CHECK(made == with_attachments(small_pdf(names), {xml, json}));
    CHECK(made.substr(0, 8) == "%PDF-1.7");
    CHECK(made.find("1-2ccd46bc, signed") != std::string::npos);  // signed_report_in() looks for it
    const ReadPdf pdf(made);
    const qpdf_oh root = qpdf_get_root(pdf.data), tree = pdf.at(root, {"/Names", "/EmbeddedFiles", "/Names"}),
                  associated = pdf.at(root, {"/AF"});
    CHECK((qpdf_oh_has_key(pdf.data, pdf.at(root, {"/Names"}), "/Dests") == QPDF_TRUE) == (*names != '\0'));
    REQUIRE(qpdf_oh_get_array_n_items(pdf.data, tree) == 4);
    REQUIRE(qpdf_oh_get_array_n_items(pdf.data, associated) == 2);
    int at = 0;
    for (const PdfAttachment* own : {&xml, &json}) {  // a name tree rises
      CHECK(qpdf_oh_get_utf8_value(pdf.data, qpdf_oh_get_array_item(pdf.data, tree, 2 * at)) == own->name);
      const qpdf_oh file = qpdf_oh_get_array_item(pdf.data, associated, at++);
      CHECK(pdf.text(file, "/UF") == own->name);
      CHECK(pdf.text(file, "/Desc") == own->description);
      CHECK(pdf.text(file, "/AFRelationship") == "/Data");
      const qpdf_oh facts = qpdf_oh_get_dict(pdf.data, pdf.at(file, {"/EF", "/F"}));
      CHECK(pdf.text(facts, "/Subtype") == "/" + own->mime);
      CHECK(pdf.content(file) == own->bytes);
    }
  }
  CHECK_THROWS_AS(with_attachments("%PDF-1.4\ndear diary", {json}), Error);
}
