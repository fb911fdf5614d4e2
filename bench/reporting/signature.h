// Detached signatures of files of reports: FILE.p7s beside FILE is CMS (RFC 5652) in DER, with the certificate of who
// signed and CAdES' attribute that binds it (RFC 5035), checked by `openssl cms -verify` alone:
//   openssl cms -verify -binary -inform DER -in FILE.p7s -content FILE -CAfile ROOT.pem -out /dev/null
// A content hint (RFC 2634) names report, kind of file and number of bytes. There is no time stamp: the time of signing
// is what the signer's own clock said.
#pragma once

#include <memory>
#include <string>

#include "bench/common/error.h"

namespace tactbench::bench {

// Files: a private key and a certificate in PEM (further ones in the file are its issuers'), or both in PKCS#12.
struct SignerFiles {
  std::string key, certificate, pkcs12;
  std::string password;  // file whose first line opens them; empty: no password
  [[nodiscard]] bool named() const { return !key.empty() || !certificate.empty() || !pkcs12.empty(); }
};

// OpenSSL's objects. Throws Error TB-REPORT-KEY for what is not there, cannot be opened, does not belong together, or
// has expired.
struct SigningKey;
std::shared_ptr<const SigningKey> read_signing_key(const SignerFiles& files);

// Writes PATH.p7s in place of an earlier one and returns its path. `number`: the signed report's. Throws Error
// TB-REPORT-KEY, TB-FILE-WRITE.
std::string sign_file(const SigningKey& key, const std::string& path, const std::string& number);

// What became of a signature, a word each.
struct SignatureFinding {
  // good: intact, by a certificate that leads to the root and is valid now | missing: no FILE.p7s | tampered: other
  // bytes | appended: the signed bytes, and more | wrong file: that of another report, or of another kind | damaged:
  // FILE.p7s itself | other root | expired: the certificate, after the time of signing | invalid then: it was not valid
  // at the time of signing | no root: intact, but no root was named to hold its certificate against
  std::string state;
  std::string words;               // for people, with what to think of it
  std::string signer, signed_utc;  // subject of the certificate; by the signer's clock; empty: not known
  ExitCode code = ExitCode::kPass;
};

// Of PATH.p7s. `root`: file of trusted certificates (PEM); empty: none is trusted. Throws Error TB-REPORT-KEY when
// `root` has none.
SignatureFinding check_signature_of(const std::string& path, const std::string& root);

}  // namespace tactbench::bench
