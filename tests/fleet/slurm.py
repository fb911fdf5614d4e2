"""A real Slurm on this machine, for tests: munged, slurmctld and slurmd in a folder of their own, without systemd, as root.
`with Slurm(folder) as slurm:` gives the environment for sbatch and squeue. None of its files and sockets is the system's."""

import os
import shutil
import signal
import socket
import subprocess
import time

TOOLS = ("munged", "mungekey", "slurmctld", "slurmd", "sbatch", "squeue", "sinfo")
PACKAGES = "slurmctld slurmd slurm-client munge"


def missing():
    """Why there can be no Slurm here; empty: there can."""
    os.environ["PATH"] += ":/usr/sbin:/sbin"
    if os.geteuid() != 0:
        return "Slurm's daemons need root"
    lacking = [tool for tool in TOOLS if shutil.which(tool) is None]
    return f"{', '.join(lacking)} not found (Debian: {PACKAGES})" if lacking else ""


def free_ports(count):
    sockets = [socket.socket() for _ in range(count)]
    try:
        for each in sockets:
            each.bind(("127.0.0.1", 0))
        return [each.getsockname()[1] for each in sockets]
    finally:
        for each in sockets:
            each.close()


class Slurm:
    def __init__(self, folder, cpus=2):
        self.folder = os.path.join(folder, "slurm")
        self.cpus = cpus
        self.daemons = []

    def __enter__(self):
        os.makedirs(self.folder, mode=0o755)
        for name in ("state", "spool", "munge"):
            os.makedirs(os.path.join(self.folder, name), mode=0o755)
        try:
            self.start()
        except BaseException:
            self.__exit__()
            raise
        return self

    def start(self):
        at = lambda name: os.path.join(self.folder, name)
        subprocess.run(["mungekey", "--create", f"--keyfile={at('munge/key')}"], check=True)
        # --force: the folders above are a test's, not /etc.
        self.run("munged", "--foreground", "--force", f"--key-file={at('munge/key')}", f"--socket={at('munge/socket')}",
                 f"--pid-file={at('munge/pid')}", f"--log-file={at('munge/log')}", f"--seed-file={at('munge/seed')}")
        self.wait("munge's socket", lambda: os.path.exists(at("munge/socket")))
        host = socket.gethostname().split(".")[0]
        control, node = free_ports(2)
        with open(at("slurm.conf"), "w") as file:
            file.write(f"""ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={control}
SlurmdPort={node}
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket={at('munge/socket')}
CredType=cred/munge
StateSaveLocation={at('state')}
SlurmdSpoolDir={at('spool')}
SlurmctldPidFile={at('slurmctld.pid')}
SlurmdPidFile={at('slurmd.pid')}
SlurmctldLogFile={at('slurmctld.log')}
SlurmdLogFile={at('slurmd.log')}
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerParameters=sched_interval=1,batch_sched_delay=0
ReturnToService=2
MpiDefault=none
SwitchType=switch/none
NodeName={host} NodeAddr=127.0.0.1 CPUs={self.cpus} State=UNKNOWN
PartitionName=all Nodes={host} Default=YES MaxTime=INFINITE State=UP
""")
        self.environment = dict(os.environ, SLURM_CONF=at("slurm.conf"))
        self.run("slurmctld", "-D", "-f", at("slurm.conf"))
        self.run("slurmd", "-D", "-f", at("slurm.conf"))
        self.wait("an idle node", lambda: self.said("sinfo", "-h", "-o", "%T").strip() == "idle")

    def run(self, *words):
        with open(os.path.join(self.folder, f"{words[0]}.out"), "w") as output:
            environment = getattr(self, "environment", os.environ)
            self.daemons.append(subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=output, stderr=output,
                                                 env=environment, start_new_session=True))

    def said(self, *words):
        return subprocess.run(words, env=self.environment, capture_output=True, text=True, timeout=60).stdout

    def wait(self, what, there, limit=60):
        last = time.monotonic() + limit
        while not there():
            if time.monotonic() > last or any(daemon.poll() is not None for daemon in self.daemons):
                raise AssertionError(f"no {what}; {self.logs()}")
            time.sleep(0.1)

    def logs(self):
        text = ""
        for name in ("munged.out", "munge/log", "slurmctld.log", "slurmd.log", "slurmctld.out", "slurmd.out"):
            path = os.path.join(self.folder, name)
            if os.path.exists(path):
                with open(path, errors="replace") as file:
                    text += f"\n== {name}\n" + "".join(file.readlines()[-15:])
        return text

    def __exit__(self, *_):
        for daemon in reversed(self.daemons):
            if daemon.poll() is None:
                daemon.send_signal(signal.SIGTERM)
                try:
                    daemon.wait(10)
                except subprocess.TimeoutExpired:
                    daemon.kill()
                    daemon.wait()
