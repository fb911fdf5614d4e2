"""What two nights of the same seeds must have in common, whoever carried them out."""

import json
import re
import subprocess


def facts(program, folder, db):
    def said(*words):
        done = subprocess.run([program, *words, "--json", "--db", db], cwd=folder, stdin=subprocess.DEVNULL,
                              capture_output=True, text=True, timeout=3600)
        assert done.returncode == 0, (words, done.stderr[-2000:])
        return json.loads(done.stdout)
    runs = said("runs", "list", "--all")["runs"]
    return ([(run["run"], run["content_sha256"], run["verdict"], run["tags"]) for run in runs], said("trend")["subjects"],
            said("trend", "baselines")["baselines"])


def page(path):
    with open(path) as file:
        text = re.sub(r"\d{4}-\d\d-\d\dT[\d:]{8}Z", "TIME", file.read())
    return re.sub(r'<td class="n">[\d.]+</td><td>', "<td>SECONDS</td><td>", text)
