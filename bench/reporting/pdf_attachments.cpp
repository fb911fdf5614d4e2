// By the C interface of qpdf: clang 16 does not compile the C++ one's headers as C++20.
#include "bench/reporting/pdf_attachments.h"

#include <fmt/format.h>
#include <qpdf/qpdf-c.h>

#include <algorithm>
#include <memory>

#include "bench/common/error.h"

namespace tactbench::bench {

namespace {

class Pdf {
 public:
  explicit Pdf(const std::string& bytes) : data_(qpdf_init()) {
    qpdf_silence_errors(data());
    qpdf_set_suppress_warnings(data(), QPDF_TRUE);
    (void)qpdf_read_memory(data(), "report", bytes.data(), bytes.size(), nullptr);
    check();
  }
  [[nodiscard]] qpdf_data data() const { return data_.get(); }

  [[nodiscard]] qpdf_oh name(const std::string& word) const { return qpdf_oh_new_name(data(), ("/" + word).c_str()); }
  [[nodiscard]] qpdf_oh text(const std::string& words) const {
    return qpdf_oh_new_unicode_string(data(), words.c_str());
  }
  [[nodiscard]] qpdf_oh dictionary(const std::vector<std::pair<const char*, qpdf_oh>>& entries) const {
    const qpdf_oh made = qpdf_oh_new_dictionary(data());
    for (const auto& [key, value] : entries) qpdf_oh_replace_key(data(), made, key, value);
    return made;
  }

  [[nodiscard]] qpdf_oh file(const PdfAttachment& own) const {
    const qpdf_oh stream = qpdf_oh_new_stream(data());
    qpdf_oh_replace_stream_data(data(), stream, reinterpret_cast<const unsigned char*>(own.bytes.data()),
                                own.bytes.size(), qpdf_oh_new_null(data()), qpdf_oh_new_null(data()));
    const qpdf_oh facts = qpdf_oh_get_dict(data(), stream);
    qpdf_oh_replace_key(data(), facts, "/Type", name("EmbeddedFile"));
    qpdf_oh_replace_key(data(), facts, "/Subtype", name(own.mime));
    const auto size = static_cast<long long>(own.bytes.size());
    qpdf_oh_replace_key(data(), facts, "/Params", dictionary({{"/Size", qpdf_oh_new_integer(data(), size)}}));
    return qpdf_make_indirect_object(data(), dictionary({{"/Type", name("Filespec")},
                                                         {"/F", text(own.name)},
                                                         {"/UF", text(own.name)},
                                                         {"/Desc", text(own.description)},
                                                         {"/AFRelationship", name("Data")},
                                                         {"/EF", dictionary({{"/F", stream}, {"/UF", stream}})}}));
  }

  [[nodiscard]] std::string written() const {
    (void)qpdf_init_write_memory(data());
    qpdf_set_deterministic_ID(data(), QPDF_TRUE);
    qpdf_set_minimum_pdf_version(data(), "1.7");
    qpdf_set_object_stream_mode(data(), qpdf_o_disable);  // its title is found without a PDF's reader
    (void)qpdf_write(data());
    check();
    return {reinterpret_cast<const char*>(qpdf_get_buffer(data())), qpdf_get_buffer_length(data())};
  }

  void check() const {
    if (qpdf_has_error(data()) == QPDF_FALSE) return;
    throw Error(
        "TB-REPORT-PDF",
        fmt::format("the data cannot be attached: {}", qpdf_get_error_full_text(data(), qpdf_get_error(data()))),
        "--format pdf", "use the other program (--pdf-with)");
  }

 private:
  struct Cleanup {
    void operator()(qpdf_data data) const { qpdf_cleanup(&data); }
  };
  std::unique_ptr<_qpdf_data, Cleanup> data_;
};

}  // namespace

std::string with_attachments(const std::string& pdf, std::vector<PdfAttachment> attachments) {
  const Pdf document(pdf);
  const qpdf_data data = document.data();
  std::ranges::sort(attachments, {}, &PdfAttachment::name);  // as a name tree requires
  const qpdf_oh tree = qpdf_oh_new_array(data), associated = qpdf_oh_new_array(data), root = qpdf_get_root(data);
  for (const PdfAttachment& own : attachments) {
    const qpdf_oh file = document.file(own);
    qpdf_oh_append_item(data, tree, document.text(own.name));
    qpdf_oh_append_item(data, tree, file);
    qpdf_oh_append_item(data, associated, file);
  }
  qpdf_oh names = qpdf_oh_get_key(data, root, "/Names");
  if (qpdf_oh_is_dictionary(data, names) == QPDF_FALSE) names = document.dictionary({});
  qpdf_oh_replace_key(data, names, "/EmbeddedFiles", document.dictionary({{"/Names", tree}}));
  qpdf_oh_replace_key(data, root, "/Names", names);
  qpdf_oh_replace_key(data, root, "/AF", associated);
  document.check();
  return document.written();
}

}  // namespace tactbench::bench
