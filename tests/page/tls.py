"""The page beyond loopback: TLS with the operator's certificate, and nothing without it.

    tls.py PROGRAM
"""

import os
import re
import socket
import ssl
import subprocess
import sys
import tempfile

LONGEST_S = 60


def expect(truth, what):
    if not truth:
        sys.exit(f"tests/page/tls.py: {what}")


def ask(stream, host, path, token):
    stream.sendall(f"GET {path} HTTP/1.1\r\nHost: {host}\r\nAuthorization: Bearer {token}\r\nConnection: close\r\n\r\n".encode())
    answer = b""
    while part := stream.recv(65536):
        answer += part
    return answer.decode(errors="replace")


def refusals(program, folder):
    """Files that cannot be used: which one, why, and what to do."""
    def openssl(*words):
        subprocess.run(["openssl", *words], cwd=folder, check=True, capture_output=True, timeout=LONGEST_S)
    openssl("pkey", "-in", "own.key", "-aes256", "-passout", "pass:secret", "-out", "locked.key")
    openssl("rsa", "-in", "own.key", "-traditional", "-aes256", "-passout", "pass:secret", "-out", "old-locked.key")
    openssl("x509", "-in", "own.pem", "-outform", "DER", "-out", "own.der")
    with open(f"{folder}/own.pem") as whole, open(f"{folder}/broken.pem", "w") as broken:
        broken.write("".join(line for i, line in enumerate(whole) if i != 3))
    for certificate, key, file, why, remedy in (
            ("own.pem", "other.key", "other.key", "does not belong to the certificate own.pem", "openssl pkey -in other.key -pubout"),
            ("none.pem", "own.key", "none.pem", "cannot be read: No such file or directory", "check the name"),
            ("own.pem", "none.key", "none.key", "cannot be read: No such file or directory", "check the name"),
            ("own.pem", ".", ".", "it is a folder", "private key"),
            ("own.key", "own.pem", "own.key", "it holds no certificate", "the certificate comes first"),
            ("own.pem", "own.pem", "own.pem", "it holds no private key", "the private key comes second"),
            ("own.der", "own.key", "own.der", "it is not in PEM", "-inform DER -in own.der"),
            ("broken.pem", "own.key", "broken.pem", "cannot be used for TLS: ", "openssl x509 -in broken.pem"),
            ("own.pem", "locked.key", "locked.key", "the private key has a passphrase", "openssl pkey -in locked.key"),
            ("own.pem", "old-locked.key", "old-locked.key", "the private key has a passphrase", "openssl pkey -in old-locked.key")):
        done = subprocess.run([program, "page", "--port", "0", "--tls", certificate, key], cwd=folder, capture_output=True, text=True,
                              stdin=subprocess.DEVNULL, timeout=LONGEST_S)
        expect(done.returncode == 2 and "asio" not in done.stderr, (certificate, key, done))
        for word in ("TB-PAGE-CERTIFICATE", f"at: {file}\n", why, "try: ", remedy):
            expect(word in done.stderr, (word, done.stderr))


def main():
    program = os.path.abspath(sys.argv[1])
    with tempfile.TemporaryDirectory() as folder:
        # Two of one name: the page has the first; a client that trusts the second alone must not take it.
        for name in ("own", "other"):
            subprocess.run(["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-keyout", f"{name}.key",
                            "-out", f"{name}.pem", "-subj", "/CN=localhost", "-addext", "subjectAltName=DNS:localhost"],
                           cwd=folder, check=True, capture_output=True, timeout=LONGEST_S)
        for words in (["init"], ["sensors", "add", "S-1"]):
            subprocess.run([program, *words], cwd=folder, check=True, capture_output=True, timeout=LONGEST_S)
        refusals(program, folder)
        page = subprocess.Popen([program, "page", "--port", "0", "--listen", "0.0.0.0", "--tls", "own.pem", "own.key"], cwd=folder,
                                stdout=subprocess.PIPE, text=True)
        try:
            line = page.stdout.readline()
            link = re.search(r"https://[^/:]+:(\d+)/#([0-9a-f]{32})", line)
            expect(link, f"no https address in: {line}")
            port, token = int(link.group(1)), link.group(2)
            trusting = ssl.create_default_context(cafile=f"{folder}/own.pem")

            def connected():
                return socket.create_connection(("127.0.0.1", port), timeout=LONGEST_S)
            with trusting.wrap_socket(connected(), server_hostname="localhost") as stream:
                expect(stream.version() in ("TLSv1.2", "TLSv1.3"), stream.version())
                answer = ask(stream, f"localhost:{port}", "/runs", token)
                expect(answer.startswith("HTTP/1.1 200 "), answer)
            with trusting.wrap_socket(connected(), server_hostname="localhost") as stream:
                answer = ask(stream, f"localhost:{port}", "/runs", "0" * 32)
                expect(answer.startswith(("HTTP/1.1 401 ", "HTTP/1.1 403 ")), answer)
            try:
                strange = ssl.create_default_context(cafile=f"{folder}/other.pem")
                strange.wrap_socket(connected(), server_hostname="localhost")
                sys.exit("a certificate that nobody signed was taken")
            except ssl.SSLCertVerificationError:
                pass
            old = ssl.create_default_context(cafile=f"{folder}/own.pem")
            old.minimum_version = old.maximum_version = ssl.TLSVersion.TLSv1_1
            old.set_ciphers("DEFAULT:@SECLEVEL=0")
            try:
                old.wrap_socket(connected(), server_hostname="localhost")
                sys.exit("TLS 1.1 was taken")
            except (ssl.SSLError, ConnectionError):
                pass
            with connected() as plain:
                try:
                    expect("200" not in ask(plain, f"localhost:{port}", "/runs", token).split("\r\n")[0], "plain HTTP was answered")
                except ConnectionError:
                    pass
            # The page still answers after all of these.
            with trusting.wrap_socket(connected(), server_hostname="localhost") as stream:
                expect(ask(stream, f"localhost:{port}", "/runs", token).startswith("HTTP/1.1 200 "), "the page ended")
        finally:
            page.terminate()
            page.wait(LONGEST_S)
    print("the page is read through TLS alone")


main()
