#!/usr/bin/python3
"""Looks at finished report pages as a reader's programs do. By command, not part of ctest: a browser is too large for CI.

    tests/analysis/pages/check_pages.py PAGE.html...

For each page: well-formed XML (xmllint); accessibility (axe-core in headless Chromium, no serious or critical finding);
printed by Chromium on A4 and Letter: every heading found by pdftotext, "page n of m" on each page, no page white for more
than a third but the last; of a report without annexes at most six pages and 400 kB. Needs chromium, libxml2-utils, poppler-utils, and npm for axe-core (fetched once into a cache folder).
"""
import html
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile

AXE = "axe-core@4.14.1"
MOST_WHITE = 1 / 3  # share of a page that may be empty below its last line, the last page apart
MOST_PAGES, MOST_BYTES = 6, 400_000


def run(words, **more):
    return subprocess.run(words, capture_output=True, text=True, timeout=900, check=False, **more)


def chromium(folder, *words):
    sandbox = ["--no-sandbox"] if os.geteuid() == 0 else []
    return run(["chromium", "--headless", "--disable-gpu", "--no-first-run", "--disable-dev-shm-usage", *sandbox,
                f"--user-data-dir={folder}/profile", *words])


def axe_source():
    cache = pathlib.Path(os.environ.get("XDG_CACHE_HOME", pathlib.Path.home() / ".cache")) / "tactbench-axe"
    script = cache / "node_modules/axe-core/axe.min.js"
    if not script.exists():
        cache.mkdir(parents=True, exist_ok=True)
        done = run(["npm", "install", "--no-audit", "--no-fund", "--ignore-scripts", "--prefix", str(cache), AXE])
        if done.returncode != 0:
            sys.exit(f"axe-core could not be fetched: {done.stderr[-400:]}")
    return script.read_text(encoding="utf-8")


def axe_findings(page, folder):
    """The page refuses scripts, so a copy without its policy is looked at."""
    text = re.sub(r'<meta http-equiv="Content-Security-Policy"[^>]*/>', "", page)
    runner = ("<script>" + axe_source().replace("</script", "<\\/script") + "</script><script>"
              "axe.run(document,{resultTypes:['violations']}).then(r=>{document.body.innerHTML='<pre id=\"axe\">'+"
              "encodeURIComponent(JSON.stringify(r.violations.map(v=>({id:v.id,impact:v.impact,count:v.nodes.length,"
              "first:v.nodes[0].html.slice(0,160)}))))+'</pre>'})</script></body>")
    copy = pathlib.Path(folder) / "axe.html"
    copy.write_text(text.replace("</body>", runner), encoding="utf-8")
    out = chromium(folder, "--virtual-time-budget=60000", "--dump-dom", copy.as_uri()).stdout
    found = re.search(r'<pre id="axe">([^<]*)</pre>', out)
    if not found:
        return [{"id": "axe did not finish", "impact": "critical", "count": 0, "first": out[-200:]}]
    from urllib.parse import unquote
    return json.loads(unquote(found.group(1)))


def white_pages(pdf, folder):
    """Share of white below the last printed row of the text area, per page."""
    run(["pdftoppm", "-r", "20", "-gray", str(pdf), f"{folder}/white"])
    shares = []
    for path in sorted(pathlib.Path(folder).glob("white*.pgm")):
        data = path.read_bytes()
        header = re.match(rb"P5\s+(\d+)\s+(\d+)\s+\d+\s", data)
        width, height = int(header.group(1)), int(header.group(2))
        pixels = data[header.end():]
        top, bottom = int(0.07 * height), int(0.93 * height)  # between the running head and the page number
        last = top
        for row in range(top, bottom):
            if min(pixels[row * width:(row + 1) * width]) < 200:
                last = row
        shares.append((bottom - last) / (bottom - top))
        path.unlink()
    return shares


def check(path, folder):
    complaints = []
    lint = run(["xmllint", "--noout", "--nonet", str(path)])
    if lint.returncode != 0:
        complaints.append("not well-formed: " + lint.stderr[:300])
    page = path.read_text(encoding="utf-8")
    findings = axe_findings(page, folder)
    for finding in findings:
        line = f"axe {finding['impact']}: {finding['id']} x {finding['count']}, first {finding['first']}"
        if finding["impact"] in ("serious", "critical"):
            complaints.append(line)
        else:
            print("  note:", line)
    body_alone = 'id="annex-of-' not in page and "Batch of sensors" not in page
    if body_alone and len(page.encode()) > MOST_BYTES:
        complaints.append(f"{len(page.encode())} bytes")
    headings = [html.unescape(re.sub("<[^>]*>", "", h)) for h in re.findall(r"<h[123][^>]*>(.*?)</h[123]>", page)]
    for paper in ("A4", "letter"):
        copy, pdf = pathlib.Path(folder) / "print.html", pathlib.Path(folder) / "print.pdf"
        copy.write_text(re.sub(r"size: (A4|letter);", f"size: {paper};", page), encoding="utf-8")
        pdf.unlink(missing_ok=True)
        chromium(folder, "--no-pdf-header-footer", f"--print-to-pdf={pdf}", copy.as_uri())
        if not pdf.exists():
            complaints.append(f"{paper}: no PDF")
            continue
        text = run(["pdftotext", "-layout", str(pdf), "-"]).stdout
        flat = " ".join(text.split())
        missing = [h for h in headings if " ".join(h.split()) not in flat]
        if missing:
            complaints.append(f"{paper}: headings not found: {missing}")
        pages = text.split("\f")[:-1]
        if body_alone and len(pages) > MOST_PAGES:
            complaints.append(f"{paper}: {len(pages)} pages")
        for number, one in enumerate(pages, 1):
            if f"page {number} of {len(pages)}" not in one:
                complaints.append(f"{paper}: page {number} does not say so")
            if "SIMULATED" in page and "SIMULATED" not in one:
                complaints.append(f"{paper}: page {number} does not say SIMULATED")
        for number, share in enumerate(white_pages(pdf, folder)[:-1], 1):
            if share > MOST_WHITE:
                complaints.append(f"{paper}: page {number} is white for {100 * share:.0f} %")
        print(f"  {paper}: {len(pages)} pages, {len(headings)} headings")
    return complaints


def main():
    failed = False
    for name in sys.argv[1:] or sys.exit(__doc__):
        print(name)
        with tempfile.TemporaryDirectory() as folder:
            complaints = check(pathlib.Path(name).resolve(), folder)
        for complaint in complaints:
            print("  FAILED:", complaint)
        failed = failed or bool(complaints)
    sys.exit(1 if failed else 0)


main()
