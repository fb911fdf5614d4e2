#include "bench/reporting/signed_reports.h"

#include <fmt/format.h>
#include <openssl/cms.h>
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/pkcs12.h>
#include <openssl/x509v3.h>

#include <algorithm>
#include <charconv>
#include <ctime>
#include <filesystem>
#include <optional>
#include <set>
#include <system_error>

#include "analysis/read_whole_file.h"
#include "analysis/report/report_facts.h"
#include "bench/common/error.h"
#include "bench/common/output_file.h"
#include "bench/common/private_files.h"
#include "bench/reporting/evidence.h"

namespace tactbench::bench {

std::string signed_report_in(const std::string& path, const db::RunStore& store) {
  std::error_code unknown;
  // A pipe would be waited for, and so would some files of /proc, which say that they are empty.
  if (!std::filesystem::is_regular_file(path, unknown) || std::filesystem::file_size(path, unknown) == 0) return {};
  const std::string text = file_text(path);
  if (text.empty()) return {};
  const std::string beginning = text.substr(0, 64);
  if (beginning.starts_with('{') || beginning.starts_with("<!DOCTYPE html>")) return signed_report_number_in(text);
  for (const db::ReportRecord& report : store.reports())
    if (text.find(analysis::signed_title_mark(report.number)) != std::string::npos) return report.number;
  return {};
}

std::string free_report_path(const db::RunStore& store, const std::string& name, const std::string& numbered,
                             const std::string& uuid) {
  const std::filesystem::path folder = std::filesystem::path(store.path()).parent_path() / "reports";
  const std::string path = (folder / name).string();
  std::error_code unknown;
  if (!std::filesystem::is_regular_file(path, unknown)) return path;
  const bool other = file_text(path).find(uuid) == std::string::npos;
  return other || !signed_report_in(path, store).empty() ? (folder / numbered).string() : path;
}

bool may_be_written(const std::string& path, const std::string& number, const db::RunStore& store) {
  const std::string there = signed_report_in(path, store);
  if (there.empty()) return true;
  if (there == number) return false;
  throw Error("TB-REPORT-SIGNED", fmt::format("the file holds the signed report {}", there), path,
              "signed reports are never overwritten: name another file with -o");
}

namespace {

// The runs of this store on which a report is based, its own first; `missing`: content hashes of runs that the store
// does not have.
std::vector<db::RunRecord> evidence_runs(const db::RunStore& store, const db::ReportRecord& report,
                                         std::vector<std::string>* missing) {
  std::vector<db::RunRecord> runs = {store.run(report.run)};
  for (const auto& [number, content] : report.evidence) {
    if (content == runs.front().content_sha256) continue;
    if (const std::optional<std::int64_t> run = run_of_source(store, {number, content}))
      runs.push_back(store.run(*run));
    else if (missing != nullptr)
      missing->push_back(fmt::format("this store does not have run {}, content {}", number, content.substr(0, 12)));
  }
  return runs;
}

}  // namespace

std::vector<std::string> void_evidence(const db::RunStore& store, const db::ReportRecord& report) {
  std::vector<std::string> sentences;
  for (const db::RunRecord& run : evidence_runs(store, report, nullptr))
    if (run.is_void()) sentences.push_back(display_text(analysis::void_of(run)));
  return sentences;
}

ReportEvidence check_evidence(const db::RunStore& store, const db::ReportRecord& report) {
  ReportEvidence found;
  for (const db::RunRecord& run : evidence_runs(store, report, &found.missing)) {
    if (run.is_void()) found.fallen.push_back(display_text(analysis::void_of(run)));
    for (const std::string& wrong : store.check_seals(run.run))
      found.fallen.push_back(fmt::format("run {}: the store was changed: {}", run.run, wrong));
    const db::ContentCheck data = store.check_content(run.run);
    if (!data.holds())
      found.fallen.push_back(fmt::format("run {}: its data were changed: {}", run.run, data.difference));
  }
  return found;
}

std::vector<db::ReportRecord> reports_based_on(const db::RunStore& store, std::int64_t run) {
  std::vector<db::ReportRecord> resting = store.reports();
  std::set<std::string> replaced;
  for (const db::ReportRecord& report : resting) replaced.insert(report.replaces);
  std::erase_if(resting, [&](const db::ReportRecord& report) {
    const std::vector<db::RunRecord> runs = evidence_runs(store, report, nullptr);
    return replaced.contains(report.number) || std::ranges::find(runs, run, &db::RunRecord::run) == runs.end();
  });
  return resting;
}

namespace {

template <auto kFree>
struct Free {
  template <class T>
  void operator()(T* object) const {
    kFree(object);
  }
};
template <class T, auto kFree>
using Owned = std::unique_ptr<T, Free<kFree>>;
using Bio = Owned<BIO, BIO_free_all>;
using Cms = Owned<CMS_ContentInfo, CMS_ContentInfo_free>;
using Certificate = Owned<X509, X509_free>;
void free_certificates(STACK_OF(X509) * all) { sk_X509_pop_free(all, X509_free); }
using Certificates = Owned<STACK_OF(X509), free_certificates>;
using Store = Owned<X509_STORE, X509_STORE_free>;

constexpr unsigned kHow = CMS_DETACHED | CMS_BINARY | CMS_NOSMIMECAP | CMS_CADES;
constexpr std::size_t kLargestKey = 1'000'000, kLargestFile = 1'000'000'000;  // bytes
constexpr std::size_t kLongestHint = 100;                                     // bytes: lengths in one byte each

[[noreturn]] void refuse(const std::string& what, const std::string& where, const std::string& remedy = {}) {
  ERR_clear_error();
  throw Error("TB-REPORT-KEY", what, where, remedy);
}

// Keys, certificates and passwords may come from a pipe.
std::string text_of_file(const std::string& path, std::size_t max_bytes = kLargestKey) {
  return analysis::read_whole_file(path, {.max_bytes = max_bytes, .or_pipe = max_bytes == kLargestKey}, "TB-REPORT-KEY",
                                   "name an existing file that can be read");
}

Bio bytes_of(const std::string& text) { return Bio(BIO_new_mem_buf(text.data(), static_cast<int>(text.size()))); }

// Never asks on the terminal, as OpenSSL's own would.
int give_password(char* to, int size, int /*writing*/, void* password) {
  const std::string& text = *static_cast<const std::string*>(password);
  if (text.size() > static_cast<std::size_t>(size)) return -1;
  text.copy(to, text.size());
  return static_cast<int>(text.size());
}

std::string utc_of(std::time_t time) {
  std::tm parts{};
  ::gmtime_r(&time, &parts);
  return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}Z", parts.tm_year + 1900, parts.tm_mon + 1, parts.tm_mday,
                     parts.tm_hour, parts.tm_min, parts.tm_sec);
}

std::time_t time_of(const ASN1_TIME* time) {
  std::tm parts{};
  return time != nullptr && ASN1_TIME_to_tm(time, &parts) == 1 ? ::timegm(&parts) : std::time_t{-1};
}

std::string subject_of(const X509* certificate) {
  const Bio out(BIO_new(BIO_s_mem()));
  X509_NAME_print_ex(out.get(), X509_get_subject_name(certificate), 0, XN_FLAG_RFC2253 & ~ASN1_STRFLGS_ESC_MSB);
  char* text = nullptr;
  const long size = BIO_get_mem_data(out.get(), &text);
  return {text, static_cast<std::size_t>(size)};
}

// "report 1-2ccd46bc; a PDF; 123456 bytes".
struct Hint {
  std::string number, kind;
  std::size_t bytes = 0;
};
std::string text_of(const Hint& hint) {
  return fmt::format("report {}; {}; {} bytes", hint.number, hint.kind, hint.bytes);
}
Hint hint_from(std::string_view text) {
  Hint hint;
  const std::size_t first = text.find("; "), last = text.rfind("; ");
  if (!text.starts_with("report ") || first == std::string_view::npos || last == first) return hint;
  hint.number = text.substr(7, first - 7);
  hint.kind = text.substr(first + 2, last - first - 2);
  std::from_chars(text.data() + last + 2, text.data() + text.size(), hint.bytes);
  return hint;
}

// ContentHints ::= SEQUENCE { contentDescription UTF8String, contentType id-data }, RFC 2634, 2.9.
constexpr std::string_view kData = "\x06\x09\x2a\x86\x48\x86\xf7\x0d\x01\x07\x01";
std::string hint_der(const std::string& description) {
  const auto length = [](std::size_t bytes) { return std::string(1, static_cast<char>(bytes)); };
  return "\x30" + length(2 + description.size() + kData.size()) + "\x0c" + length(description.size()) + description +
         std::string(kData);
}
Hint hint_of(const ASN1_STRING* der) {
  if (der == nullptr) return {};
  const std::string_view text(reinterpret_cast<const char*>(ASN1_STRING_get0_data(der)),
                              static_cast<std::size_t>(ASN1_STRING_length(der)));
  if (text.size() < 4 || text[0] != '\x30' || text[2] != '\x0c' ||
      text.size() < 4U + static_cast<unsigned char>(text[3]))
    return {};
  return hint_from(text.substr(4, static_cast<unsigned char>(text[3])));
}

std::string beginning_of(const std::string& text) { return text.substr(0, std::size_t{1} << 16); }

const ASN1_STRING* attribute(CMS_SignerInfo* signer, int nid, int type) {
  return static_cast<const ASN1_STRING*>(CMS_signed_get0_data_by_OBJ(signer, OBJ_nid2obj(nid), -3, type));
}

std::time_t signing_time(CMS_SignerInfo* signer) {
  const int at = CMS_signed_get_attr_by_NID(signer, NID_pkcs9_signingTime, -1);
  const ASN1_TYPE* const value = at < 0 ? nullptr : X509_ATTRIBUTE_get0_type(CMS_signed_get_attr(signer, at), 0);
  if (value == nullptr || (value->type != V_ASN1_UTCTIME && value->type != V_ASN1_GENERALIZEDTIME)) return -1;
  return time_of(value->value.asn1_string);
}

bool has_digest(const ASN1_STRING* digest, const EVP_MD* how, std::string_view bytes) {
  unsigned char own[EVP_MAX_MD_SIZE];
  unsigned size = 0;
  return digest != nullptr && how != nullptr && EVP_Digest(bytes.data(), bytes.size(), own, &size, how, nullptr) == 1 &&
         size == static_cast<unsigned>(ASN1_STRING_length(digest)) &&
         std::equal(own, own + size, ASN1_STRING_get0_data(digest));
}

Store roots_from(const std::string& path) {
  const std::string text = text_of_file(path);
  const Bio in = bytes_of(text);
  Store store(X509_STORE_new());
  bool any = false;
  while (const Certificate root{PEM_read_bio_X509(in.get(), nullptr, nullptr, nullptr)})
    any = X509_STORE_add_cert(store.get(), root.get()) == 1 || any;
  ERR_clear_error();  // the end of the file
  if (!any) refuse("it contains no certificate in PEM", path);
  return store;
}

// As `openssl cms -verify` judges a chain. `at` -1: now.
int chain_error(X509_STORE* roots, X509* certificate, STACK_OF(X509) * others, std::time_t at) {
  const Owned<X509_STORE_CTX, X509_STORE_CTX_free> context(X509_STORE_CTX_new());
  if (X509_STORE_CTX_init(context.get(), roots, certificate, others) != 1) return X509_V_ERR_UNSPECIFIED;
  X509_STORE_CTX_set_default(context.get(), "smime_sign");
  if (at >= 0) X509_STORE_CTX_set_time(context.get(), 0, at);
  const bool good = X509_verify_cert(context.get()) == 1;
  ERR_clear_error();
  return good ? X509_V_OK : X509_STORE_CTX_get_error(context.get());
}

SignatureFinding finding(std::string state, std::string text, ExitCode code) {
  return {std::move(state), std::move(text), "", "", code};
}
SignatureFinding damaged(const std::string& why) {
  return finding("damaged", "DAMAGED: the signature itself " + why, ExitCode::kCriterionFailed);
}

// Classifies bytes that differ from the signed ones.
SignatureFinding other_bytes(const std::string& content, const Hint& hint, const ASN1_STRING* digest,
                             const EVP_MD* how) {
  const std::string signed_file =
      hint.number.empty() ? "another file" : fmt::format("{} of report {}", hint.kind, hint.number);
  if (hint.bytes > 0 && content.size() > hint.bytes &&
      has_digest(digest, how, std::string_view(content).substr(0, hint.bytes)))
    return finding("appended",
                   fmt::format("APPENDED: {} bytes were added after the signed ones", content.size() - hint.bytes),
                   ExitCode::kCriterionFailed);
  if (!hint.number.empty() &&
      (kind_of_file(beginning_of(content)) != hint.kind || content.find(hint.number) == std::string::npos))
    return finding("wrong file", "WRONG FILE: the signature is for " + signed_file, ExitCode::kCriterionFailed);
  return finding("tampered", fmt::format("TAMPERED: the bytes differ from the signed ones ({})", signed_file),
                 ExitCode::kCriterionFailed);
}

SignatureFinding certificate_finding(const std::string& root, X509* signer, STACK_OF(X509) * others, std::time_t at) {
  if (root.empty())
    return finding("no root", "the bytes are the signed ones; --root ROOT.pem is needed to verify the signer",
                   ExitCode::kInconclusive);
  const Store roots = roots_from(root);
  const int now = chain_error(roots.get(), signer, others, -1);
  if (now == X509_V_OK)
    return finding("good", "good: the certificate chains to the root and is valid", ExitCode::kPass);
  if (now != X509_V_ERR_CERT_HAS_EXPIRED && now != X509_V_ERR_CERT_NOT_YET_VALID)
    return finding(
        "other root",
        fmt::format("OTHER ROOT: the certificate does not chain to this root ({})", X509_verify_cert_error_string(now)),
        ExitCode::kCriterionFailed);
  if (at >= 0 && chain_error(roots.get(), signer, others, at) == X509_V_OK)
    return finding("expired",
                   "expired: the certificate was valid when signed, by the signer's own clock; it is not valid now, "
                   "and no time stamp proves the time of signing",
                   ExitCode::kInconclusive);
  return finding("invalid then",
                 fmt::format("INVALID THEN: at the time of signing, by the signer's own clock, the certificate was not "
                             "valid ({})",
                             X509_verify_cert_error_string(now)),
                 ExitCode::kCriterionFailed);
}

}  // namespace

struct SigningKey {
  std::shared_ptr<EVP_PKEY> key;
  std::shared_ptr<X509> certificate;
  std::shared_ptr<STACK_OF(X509)> issuers;
};

std::shared_ptr<const SigningKey> read_signing_key(const SignerFiles& files) {
  const bool pem = !files.key.empty() && !files.certificate.empty() && files.pkcs12.empty();
  if (!pem && (files.pkcs12.empty() || !files.key.empty() || !files.certificate.empty()))
    refuse("a signature needs a key and a certificate, or one PKCS#12 file with both", "report sign",
           "--key KEY.pem --certificate CERT.pem, or --pkcs12 FILE.p12");
  std::string password = files.password.empty() ? "" : text_of_file(files.password);
  password.resize(std::min(password.size(), password.find_first_of("\r\n")));
  auto out = std::make_shared<SigningKey>();
  if (pem) {
    const std::string key = text_of_file(files.key), certificates = text_of_file(files.certificate);
    const Bio key_bytes = bytes_of(key), certificate_bytes = bytes_of(certificates);
    out->key.reset(PEM_read_bio_PrivateKey(key_bytes.get(), nullptr, give_password, &password), EVP_PKEY_free);
    if (!out->key) refuse("it is not a private key in PEM, or the password does not open it", files.key);
    out->certificate.reset(PEM_read_bio_X509(certificate_bytes.get(), nullptr, nullptr, nullptr), X509_free);
    if (!out->certificate) refuse("it contains no certificate in PEM", files.certificate);
    out->issuers.reset(sk_X509_new_null(), free_certificates);
    while (X509* const more = PEM_read_bio_X509(certificate_bytes.get(), nullptr, nullptr, nullptr))
      sk_X509_push(out->issuers.get(), more);
  } else {
    const std::string text = text_of_file(files.pkcs12);
    const Bio bytes = bytes_of(text);
    const Owned<PKCS12, PKCS12_free> box(d2i_PKCS12_bio(bytes.get(), nullptr));
    if (!box) refuse("it is not a PKCS#12 file", files.pkcs12);
    EVP_PKEY* key = nullptr;
    X509* certificate = nullptr;
    STACK_OF(X509)* issuers = nullptr;
    const bool opened = PKCS12_parse(box.get(), password.c_str(), &key, &certificate, &issuers) == 1;
    out->key.reset(key, EVP_PKEY_free);
    out->certificate.reset(certificate, X509_free);
    out->issuers.reset(issuers, free_certificates);
    if (!opened)
      refuse("the password does not open it", files.pkcs12, "name a file with the password: --password-file");
    if (!out->key || !out->certificate) refuse("it lacks the key or its certificate", files.pkcs12);
  }
  const std::string& where = pem ? files.certificate : files.pkcs12;
  if (X509_check_private_key(out->certificate.get(), out->key.get()) != 1)
    refuse("the certificate belongs to another key", where);
  if (X509_cmp_current_time(X509_get0_notAfter(out->certificate.get())) < 0)
    refuse("the certificate has expired on " + utc_of(time_of(X509_get0_notAfter(out->certificate.get()))), where,
           "sign with one that is valid");
  ERR_clear_error();
  return out;
}

std::string sign_file(const SigningKey& key, const std::string& path, const std::string& number) {
  const std::string content = text_of_file(path, kLargestFile);
  const std::string hint =
      text_of(Hint{number, kind_of_file(beginning_of(content)), content.size()}).substr(0, kLongestHint);
  const std::string der = hint_der(hint);
  const Bio bytes = bytes_of(content), out(BIO_new(BIO_s_mem()));
  const Cms cms(CMS_sign(nullptr, nullptr, key.issuers.get(), nullptr, kHow | CMS_PARTIAL));
  CMS_SignerInfo* const signer =
      cms ? CMS_add1_signer(cms.get(), key.certificate.get(), key.key.get(), EVP_sha256(), kHow) : nullptr;
  if (signer == nullptr ||
      CMS_signed_add1_attr_by_NID(signer, NID_id_smime_aa_contentHint, V_ASN1_SEQUENCE, der.data(),
                                  static_cast<int>(der.size())) != 1 ||
      CMS_final(cms.get(), bytes.get(), nullptr, kHow) != 1 || i2d_CMS_bio(out.get(), cms.get()) != 1) {
    const char* const reason = ERR_reason_error_string(ERR_peek_last_error());
    refuse(fmt::format("the key cannot sign: {}", reason == nullptr ? "OpenSSL does not say why" : reason), path,
           "use an RSA or an ECDSA key");
  }
  char* text = nullptr;
  const long size = BIO_get_mem_data(out.get(), &text);
  write_whole(path + ".p7s", {text, static_cast<std::size_t>(size)});
  return path + ".p7s";
}

SignatureFinding check_signature_of(const std::string& path, const std::string& root) {
  std::error_code unknown;
  if (!std::filesystem::is_regular_file(path + ".p7s", unknown))
    return finding("missing", fmt::format("missing: {}.p7s does not exist", path), ExitCode::kInconclusive);
  if (std::filesystem::file_size(path + ".p7s", unknown) > kLargestKey)
    return damaged("is not a CMS signature by one signer");
  const std::string signature = file_text(path + ".p7s"), content = text_of_file(path, kLargestFile);
  const Bio bytes = bytes_of(signature);
  const Cms cms(d2i_CMS_bio(bytes.get(), nullptr));
  STACK_OF(CMS_SignerInfo)* const signers =
      cms && OBJ_obj2nid(CMS_get0_type(cms.get())) == NID_pkcs7_signed ? CMS_get0_SignerInfos(cms.get()) : nullptr;
  ERR_clear_error();
  if (signers == nullptr || sk_CMS_SignerInfo_num(signers) != 1) return damaged("is not a CMS signature by one signer");
  CMS_SignerInfo* const signer = sk_CMS_SignerInfo_value(signers, 0);
  const Certificates others(CMS_get1_certs(cms.get()));
  X509* certificate = nullptr;
  if (CMS_set1_signers_certs(cms.get(), nullptr, 0) == 1)
    CMS_SignerInfo_get0_algs(signer, nullptr, &certificate, nullptr, nullptr);
  if (certificate == nullptr) return damaged("lacks the signer's certificate");
  const bool sealed = CMS_SignerInfo_verify(signer) == 1;  // its statement about the file is the signed one
  ERR_clear_error();
  if (!sealed) return damaged("is not by the key of its certificate");
  X509_ALGOR* algorithm = nullptr;
  CMS_SignerInfo_get0_algs(signer, nullptr, nullptr, &algorithm, nullptr);
  const EVP_MD* const how = EVP_get_digestbyobj(algorithm->algorithm);
  const ASN1_STRING* const digest = attribute(signer, NID_pkcs9_messageDigest, V_ASN1_OCTET_STRING);
  const std::time_t at = signing_time(signer);
  SignatureFinding found =
      !has_digest(digest, how, content)
          ? other_bytes(content, hint_of(attribute(signer, NID_id_smime_aa_contentHint, V_ASN1_SEQUENCE)), digest, how)
          : certificate_finding(root, certificate, others.get(), at);
  if (found.state == "good") {  // checks all of it by OpenSSL itself
    const Store roots = roots_from(root);
    const Bio again = bytes_of(content);
    const unsigned cades =
        CMS_signed_get_attr_by_NID(signer, NID_id_smime_aa_signingCertificateV2, -1) < 0 ? 0 : CMS_CADES;
    if (CMS_verify(cms.get(), nullptr, roots.get(), again.get(), nullptr, CMS_BINARY | CMS_DETACHED | cades) != 1)
      found = damaged("names a certificate that it does not contain");
    ERR_clear_error();
  }
  found.signer = subject_of(certificate);
  if (at >= 0) found.signed_utc = utc_of(at);
  return found;
}

}  // namespace tactbench::bench
