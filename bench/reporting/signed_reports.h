// Signed reports: the signature, its check, and the protection of a signed file from being overwritten.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "bench/common/error.h"
#include "db/run_store.h"

namespace tactbench::bench {

struct SigningKey;

// File extensions of a report: page, PDF, data, digital calibration certificate.
inline constexpr std::array kReportEndings = {"html", "pdf", "json", "xml"};

// Number of the signed report in the file; empty: no such file, or not a signed report. HTML and JSON are recognised by
// their data, whatever their names; other files by the report numbers signed in this store.
std::string signed_report_in(const std::string& path, const db::RunStore& store);

// reports/NAME next to the store; reports/NUMBERED if NAME holds a signed report, or the report of a run with another
// UUID than `uuid`, from another store in this folder.
std::string free_report_path(const db::RunStore& store, const std::string& name, const std::string& numbered,
                             const std::string& uuid);

// Whether report `number` may be written to `path`: false when the file already holds this report, signed. Throws
// TB-REPORT-SIGNED when it holds another signed report.
bool may_be_written(const std::string& path, const std::string& number, const db::RunStore& store);

// Why the evidence of a signed report is no longer valid, one sentence each: a run on which it is based is void, or was
// changed in the store. `missing`: runs that this store does not have, so they cannot be checked.
struct ReportEvidence {
  std::vector<std::string> fallen, missing;
};
ReportEvidence check_evidence(const db::RunStore& store, const db::ReportRecord& report);
// Only the sentences about void runs, without reading any data.
std::vector<std::string> void_evidence(const db::RunStore& store, const db::ReportRecord& report);
// The signed reports that are based on a run, its own among them; without reports that a later one replaced.
std::vector<db::ReportRecord> reports_based_on(const db::RunStore& store, std::int64_t run);

// Detached signatures of report files: FILE.p7s next to FILE is CMS (RFC 5652) in DER, with the signer's certificate
// and the CAdES attribute that binds it (RFC 5035). OpenSSL alone can check it:
//   openssl cms -verify -binary -inform DER -in FILE.p7s -content FILE -CAfile ROOT.pem -out /dev/null
// A content hint (RFC 2634) names report, kind of file and number of bytes. There is no trusted time stamp: the time of
// signing is that of the signer's clock.
// Files: a private key and a certificate in PEM (further certificates in the file are those of its issuers), or both in
// PKCS#12.
struct SignerFiles {
  std::string key, certificate, pkcs12;
  std::string password;  // file with the password in its first line; empty: no password
  [[nodiscard]] bool named() const { return !key.empty() || !certificate.empty() || !pkcs12.empty(); }
};

// OpenSSL's objects. Throws Error TB-REPORT-KEY if a file is missing, cannot be opened or has expired, or if key and
// certificate do not match.
std::shared_ptr<const SigningKey> read_signing_key(const SignerFiles& files);

// Writes PATH.p7s, replacing an earlier one, and returns its path. `number`: of the signed report. Throws Error
// TB-REPORT-KEY, TB-FILE-WRITE.
std::string sign_file(const SigningKey& key, const std::string& path, const std::string& number);

// Result of checking a signature.
struct SignatureFinding {
  // good: intact, and the certificate chains to the root and is valid now | missing: no FILE.p7s | tampered: other
  // bytes | appended: the signed bytes, and more | wrong file: file of another report, or of another kind | damaged:
  // FILE.p7s is damaged | other root: the certificate does not chain to the root | expired: the certificate expired
  // after the signing | invalid then: the certificate was not valid at the time of signing | no root: intact, but no
  // root was given to check the certificate
  std::string state;
  std::string text;                // explanation for the user
  std::string signer, signed_utc;  // subject of the certificate; time by the signer's clock; empty: not known
  ExitCode code = ExitCode::kPass;
};

// Checks PATH.p7s. `root`: file of trusted certificates (PEM); empty: none is trusted. Throws Error TB-REPORT-KEY if
// `root` contains no certificate.
SignatureFinding check_signature_of(const std::string& path, const std::string& root);

}  // namespace tactbench::bench
