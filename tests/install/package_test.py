"""Builds the Debian packages from the build as it stands, looks into them, and has lintian judge them. Arguments:
cpack, build folder, version, lintian or nothing."""

import os
import re
import subprocess
import sys
import tempfile

CPACK, BUILD, VERSION = sys.argv[1:4]
LINTIAN = sys.argv[4] if len(sys.argv) > 4 else ""
PACKAGES = ("tactbench", "libtactbench-compensator1", "libtactbench-compensator-dev", "python3-tactbench-compensator")


def output(*words):
    return subprocess.run(words, check=True, capture_output=True, text=True, timeout=900).stdout


with tempfile.TemporaryDirectory() as folder:
    done = subprocess.run([CPACK, "-G", "DEB", "-B", folder, "--config", os.path.join(BUILD, "CPackConfig.cmake")],
                          cwd=folder, capture_output=True, text=True, timeout=900)
    assert done.returncode == 0, done.stdout + done.stderr
    files = {name: os.path.join(folder, file) for name in PACKAGES for file in os.listdir(folder)
             if file.startswith(f"{name}_{VERSION}-0upstream1_") and file.endswith(".deb")}
    assert set(files) == set(PACKAGES), os.listdir(folder)

    contents = {name: output("dpkg-deb", "--contents", file) for name, file in files.items()}
    for name, lines in contents.items():
        for line in lines.splitlines():
            mode, owner = line.split()[:2]
            assert owner == "root/root" and "s" not in mode.lower(), line  # no setuid, no setgid
            assert re.match("l|d.{2}x.{2}xr-x|-rw.r--r--|-rwxr-xr-x", mode), line
        for document in ("copyright", "changelog.Debian.gz"):
            assert f"./usr/share/doc/{name}/{document}" in lines, (name, document)
    for path in ("bin/tactbench", "lib/udev/rules.d/70-tactbench.rules", "lib/systemd/system/tactbench-nightly.timer",
                 "lib/sysusers.d/tactbench.conf", "lib/tmpfiles.d/tactbench.conf", "share/man/man1/tactbench.1.gz", "share/tactbench/sequences/descending.toml"):
        assert f"./usr/{path}\n" in contents["tactbench"], path
    assert "libtactbench_compensator.so.1.0.0" in contents["libtactbench-compensator1"]
    assert "libtactbench_compensator.so ->" in contents["libtactbench-compensator-dev"]

    def field(name, key):
        return output("dpkg-deb", "--field", files[name], key)

    for library in ("libmodbus5", "libserialport0", "libhidapi-hidraw0", "libsqlite3-0", "libssl3", "libqpdf29", "libqrencode4", "libc6"):
        assert library in field("tactbench", "Depends"), (library, field("tactbench", "Depends"))
    assert f"libtactbench-compensator1 (= {VERSION}-0upstream1)" in field("libtactbench-compensator-dev", "Depends")

    assert "adduser" in field("tactbench", "Depends")
    scripts = os.path.join(folder, "scripts")
    output("dpkg-deb", "--control", files["tactbench"], scripts)
    postinst = os.path.join(scripts, "postinst")
    assert os.access(postinst, os.X_OK)
    stand_ins = os.path.join(folder, "stand-ins")  # the machine's own groups and folders are none of a test's
    os.mkdir(stand_ins)
    for name, line in (("addgroup", 'echo "addgroup $@" >> "$0/../said"'), ("install", 'echo "install $@" >> "$0/../said"'),
                       ("getent", 'test -e "$0.knows"')):
        with open(os.path.join(stand_ins, name), "w") as stand_in:
            stand_in.write(f"#!/bin/sh\n{line}\n".replace("$0/../", stand_ins + "/"))
        os.chmod(stand_in.name, 0o755)
    for known in (False, True):
        if known:
            open(os.path.join(stand_ins, "getent.knows"), "w").close()
        subprocess.run([postinst, "configure"], check=True, env={**os.environ, "PATH": f"{stand_ins}:{os.environ['PATH']}"})
    with open(os.path.join(stand_ins, "said")) as said:
        lines = said.read().splitlines()
    assert lines.count("addgroup --system --quiet tactbench") == 1, lines
    if not os.path.isdir("/var/lib/tactbench"):
        assert "install -d -m 2770 -o root -g tactbench /var/lib/tactbench" in lines, lines

    root = os.path.join(folder, "root")
    output("dpkg-deb", "--extract", files["tactbench"], root)
    plan = subprocess.run([os.path.join(root, "usr/bin/tactbench"), "plan", "descending"], cwd=root, capture_output=True,
                          text=True, timeout=600)
    assert plan.returncode == 0, plan.stderr
    if LINTIAN:
        judged = subprocess.run([LINTIAN, "--allow-root", "--no-cfg", "--fail-on", "error,warning", *files.values()],
                                capture_output=True, text=True, timeout=900)
        assert judged.returncode == 0, judged.stdout + judged.stderr
print("four packages", "and lintian is content" if LINTIAN else "; lintian is not installed")
