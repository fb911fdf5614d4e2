"""What is known of an executable of tests without a mutant, and how it becomes one."""
import dataclasses
import struct
import tempfile

from . import test_runs

CONTROL_BYTES = 1 << 16  # woven.h


@dataclasses.dataclass
class Measured:
    """An executable of tests without a mutant."""
    name: str
    wall_s: float
    cpu_s: float
    seconds: dict  # of each test that passes, in their order
    reached: dict  # test -> numbers of the places that it reaches
    before: set  # numbers reached before the first test

    def limit(self, names):
        """What a mutant of these tests may take. Waits stretch on a busy machine, computation does not."""
        wall = sum(self.seconds[name] for name in names)
        return test_runs.Limit(6 * wall + 30, 3 * wall * max(1.0, self.cpu_s / self.wall_s) + 10)

    def batches(self, names):
        """The names, quick tests first."""
        for low, high in ((0.0, 0.2), (0.2, 2.0), (2.0, float("inf"))):
            batch = [name for name in names if low <= self.seconds[name] < high]
            if batch:
                yield batch

    def run(self, linked, names):
        """Runs the tests of these names up to the first failure; `linked` gives the path of an executable by its name."""
        return run_named(linked(self.name), names, self.limit(names))


def choose(slot, number):
    """From here on the slot's executables are this mutant, 0: none; and no place was reached."""
    path = slot / "control"
    if not path.exists():
        path.write_bytes(bytes(CONTROL_BYTES))
        path.chmod(0o666)  # as tests write it that gave up root's rights
    with open(path, "r+b") as file:
        file.write(struct.pack("=i", number).ljust(CONTROL_BYTES, b"\0"))


def reached_since_chosen(slot):
    """Numbers of the places that were reached, in all processes."""
    return {number for number, reached in enumerate((slot / "control").read_bytes()[4:]) if reached}


def run_named(executable, names, limit):
    """Runs the tests of these names up to the first failure."""
    with tempfile.NamedTemporaryFile("w", prefix="tbm-", suffix=".names", encoding="utf-8") as file:
        file.write("".join(test_runs.spec(name) + "\n" for name in names))
        file.flush()
        return test_runs.run(executable, ["-a", "-w", "NoTests", "-f", file.name], limit)
