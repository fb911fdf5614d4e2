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
    """Keys that cannot be used end the program, which says which file it was; tests/bench/page/access_rules.cpp has the others."""
    subprocess.run(["openssl", "rsa", "-in", "own.key", "-traditional", "-aes256", "-passout", "pass:secret", "-out", "locked.key"],
                   cwd=folder, check=True, capture_output=True, timeout=LONGEST_S)
    for key in ("other.key", "locked.key"):
        done = subprocess.run([program, "page", "--port", "0", "--tls", "own.pem", key], cwd=folder, capture_output=True, text=True,
                              stdin=subprocess.DEVNULL, timeout=LONGEST_S)
        expect(done.returncode == 2 and "TB-PAGE-CERTIFICATE" in done.stderr and key in done.stderr, (key, done))


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
            try:
                strange = ssl.create_default_context(cafile=f"{folder}/other.pem")
                strange.wrap_socket(connected(), server_hostname="localhost")
                sys.exit("a certificate that nobody signed was taken")
            except ssl.SSLCertVerificationError:
                pass
        finally:
            page.terminate()
            page.wait(LONGEST_S)
    print("the page is read through TLS alone")


main()
