#!/usr/bin/python3
"""Signatures of report files: each fate is an answer of its own, with its exit code, and openssl alone agrees on each.

    signatures.py PROGRAM
"""

import json
import os
import shutil
import subprocess
import sys
import tempfile
import time

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PROGRAM = os.path.abspath(sys.argv[1])
CA = """[ca]
default_ca = own
[own]
database = index.txt
new_certs_dir = .
default_md = sha256
policy = any
unique_subject = no
rand_serial = yes
x509_extensions = leaf
[any]
commonName = supplied
[leaf]
keyUsage = critical, digitalSignature
[root]
basicConstraints = critical, CA:true
keyUsage = critical, keyCertSign
[req]
distinguished_name = none
[none]
"""
LAB = 'schema = 1\nlaboratory = "L"\ncity = "C"\ncountry = "DE"\ncustomer = "R"\ncustomer_address = "S"\n'
# fate: exit code of `report verify`, whether openssl takes the signature
FATES = {"good": (0, True), "tampered": (1, False), "appended": (1, False), "wrong file": (1, False), "damaged": (1, False),
         "other root": (1, False), "invalid then": (1, False), "expired": (6, False), "missing": (6, False)}


def call(*words, codes=(0, 1, 6)):
    done = subprocess.run([PROGRAM, *words], capture_output=True, text=True, timeout=300, check=False,
                          env={**os.environ, "TACTBENCH_SHARE": ROOT})
    assert done.returncode in codes, (words, done.returncode, done.stderr)
    return done


def openssl(*words, check=True):
    return subprocess.run(["openssl", *words], capture_output=True, text=True, check=check).returncode == 0


def utc(moved_s):
    return time.strftime("%Y%m%d%H%M%SZ", time.gmtime(time.time() + moved_s))


def make_root(name):
    openssl("req", "-x509", "-newkey", "rsa:2048", "-nodes", "-subj", f"/CN={name}", "-days", "10", "-config", "ca.cnf", "-extensions",
            "root", "-keyout", name + ".key", "-out", name + ".pem")


def make_signer(name, kind, begin_s=-3600, end_s=86400):
    openssl("genpkey", "-algorithm", *kind, "-out", name + ".key")
    openssl("req", "-new", "-key", name + ".key", "-subj", f"/CN={name}", "-config", "ca.cnf", "-out", name + ".csr")
    openssl("ca", "-batch", "-config", "ca.cnf", "-keyfile", "root.key", "-cert", "root.pem", "-startdate", utc(begin_s), "-enddate",
            utc(end_s), "-notext", "-in", name + ".csr", "-out", name + ".pem")


def agrees(file, root="root.pem", *more):
    return openssl("cms", "-verify", "-binary", "-cades", "-inform", "DER", "-in", file + ".p7s", "-content", file, "-CAfile", root,
                   "-out", os.devnull, *more, check=False)


def verified(file, root="root.pem"):
    done = call("report", "verify", file, "--root", root, "--json", "--db", "none.db")  # by the signature alone
    return done.returncode, json.loads(done.stdout)["files"][0]["signature"]


def check(fate, file, root="root.pem"):
    code, taken = FATES[fate]
    told = verified(file, root)
    assert (told[0], told[1]["state"]) == (code, fate), (fate, file, told)
    assert agrees(file, root) == taken, (fate, file)
    words = call("report", "verify", file, "--root", root, "--db", "none.db").stdout
    assert "signature " in words
    return words


def change(name, turn):
    with open(name, "rb") as file:
        data = file.read()
    with open(name, "wb") as file:
        file.write(turn(data))


def copy_of(file, name):
    shutil.copy(file, name)
    if os.path.exists(file + ".p7s"):
        shutil.copy(file + ".p7s", name + ".p7s")
    return name


with tempfile.TemporaryDirectory() as folder:
    os.chdir(folder)
    for name, text in (("ca.cnf", CA), ("lab.toml", LAB), ("index.txt", ""), ("password", "open sesame\n"), ("wrong", "sesame\n")):
        with open(name, "w", encoding="utf-8") as file:
            file.write(text)
    make_root("root")
    make_root("other")
    make_signer("rsa", ["RSA"])
    make_signer("ec", ["EC", "-pkeyopt", "ec_paramgen_curve:P-256"])
    make_signer("old", ["RSA"], -7200, -3600)
    openssl("pkcs12", "-export", "-inkey", "ec.key", "-in", "ec.pem", "-passout", "file:password", "-out", "ec.p12")
    openssl("pkey", "-in", "rsa.key", "-aes256", "-passout", "file:password", "-out", "locked.key")
    pem = ["--key", "rsa.key", "--certificate", "rsa.pem"]
    box = ["--pkcs12", "ec.p12", "--password-file", "password"]
    locked = ["--key", "locked.key", "--certificate", "rsa.pem", "--password-file", "password"]

    call("demo", "-q")
    # Before anything is signed: keys that cannot sign.
    for wrong in (["--key", "rsa.key"], ["--key", "rsa.key", "--certificate", "ec.pem"], ["--key", "old.key", "--certificate", "old.pem"],
                  ["--key", "locked.key", "--certificate", "rsa.pem"], [*box[:3], "wrong"], [*pem, *box], ["--pkcs12", "rsa.pem"],
                  ["--key", "nowhere", "--certificate", "rsa.pem"]):
        assert "TB-REPORT-KEY" in call("report", "sign", "1", "--by", "C. Chief", *wrong, codes=(2,)).stderr, wrong
    call("report", "sign", "1", codes=(2,))
    call("report", "sign", "1", "--lab", "lab.toml", "--by", "C. Chief", "-q", *pem)
    number = json.loads(call("report", "list", "--json").stdout)["reports"][0]["number"]
    page = f"reports/run-{number}.html"
    # Further files of the signed report, each signed by itself; a draft is not.
    files = [page]
    for form, ending in (("json", "json"), ("dcc", "xml"), *((("pdf", "pdf"),) if shutil.which("chromium") else ())):
        call("report", "1", "--lab", "lab.toml", "--format", form, "-q")
        files.append(f"reports/run-{number}.{ending}")
    call("report", "sign", files[1], *box, codes=(0,))
    call("report", "sign", *files[2:], *locked, codes=(0,))
    call("report", "2", "-o", "draft.html", "-q")
    assert "TB-REPORT-KEY" in call("report", "sign", "draft.html", *pem, codes=(2,)).stderr
    for file in files:
        assert "C. Chief" in call("report", "verify", file, "--root", "root.pem", codes=(0,)).stdout
        check("good", file)
        assert verified(file)[1]["signer"] in ("CN=rsa", "CN=ec")
        call("report", "verify", file, codes=(6,))  # whose signature it is needs a root
        check("other root", file, "other.pem")
        bad = copy_of(file, "bad" + os.path.splitext(file)[1])
        change(bad, lambda data: data[:len(data) // 2] + bytes([data[len(data) // 2] ^ 1]) + data[len(data) // 2 + 1:])
        check("tampered", bad)
        bad = copy_of(file, "bad")
        change(bad, lambda data: data + b"\n")
        check("appended", bad)
        bad = copy_of(file, "bad")
        change(bad + ".p7s", lambda data: data[:-20] + bytes([data[-20] ^ 1]) + data[-19:])
        check("damaged", bad)
        os.remove("bad.p7s")
        check("missing", bad)
    # The signature of one file beside another: of another kind, and of another report.
    shutil.copy(files[0] + ".p7s", files[1] + ".p7s")
    check("wrong file", files[1])
    shutil.copy(files[0] + ".p7s", "draft.html.p7s")
    check("wrong file", "draft.html")
    call("report", "verify", files[1], "--root", "root.pem", codes=(1,))  # its bytes are good, its signature is not
    # A certificate that is valid when it signs, and is not afterwards.
    make_signer("brief", ["RSA"], -60, 4)
    call("report", "sign", page, "--key", "brief.key", "--certificate", "brief.pem", codes=(0,))
    signed_at = int(time.time())
    check("good", page)
    time.sleep(max(0.0, signed_at + 6 - time.time()))
    check("expired", page)
    assert agrees(page, "root.pem", "-attime", str(signed_at))
    # One that had expired when openssl signed by it; a file that is no signature.
    openssl("cms", "-sign", "-binary", "-cades", "-outform", "DER", "-signer", "old.pem", "-inkey", "old.key", "-in", page, "-out",
            page + ".p7s")
    check("invalid then", page)
    change(page + ".p7s", lambda data: b"dear diary")
    check("damaged", page)
    change(page + ".p7s", lambda data: data * 200_000)  # too long for a signature
    check("damaged", page)
    # What another program signed well is good.
    openssl("cms", "-sign", "-binary", "-cades", "-outform", "DER", "-signer", "ec.pem", "-inkey", "ec.key", "-in", page, "-out",
            page + ".p7s")
    check("good", page)
    assert "TB-REPORT-KEY" in call("report", "verify", page, "--root", page, codes=(2,)).stderr
    print(f"{len(FATES)} fates of signatures, {len(files)} files")
