"""Shows how far the runs are: one line redrawn on a terminal, otherwise a line for each run that ends."""
import statistics
import sys
import time

EVERY = 0.5  # s between two drawings


class Progress:
    """Counts what is done; corrects the estimates by what the runs took."""

    def __init__(self, study, jobs, cores):
        self.study, self.n, self.cores = study, len(jobs), cores
        self.is_terminal = sys.stdout.isatty()
        self.ratios, self.done, self.drawn = [], 0, 0.

    def ended(self, job, record):
        """Says how a run ended."""
        self.done += 1
        if record.status == "finished" and job.estimate.get("time"):
            self.ratios.append(record.cpu / job.seconds)
        end = record.status if record.status == "finished" else f"{record.status} ({record.message})"
        self._clear()
        print(f"{self.done}/{self.n} {job.case.name}: {end}, {duration(record.cpu)} of CPU time", flush=True)

    def show(self, running, waiting):
        """Draws the line with the time left."""
        now = time.time()
        if not self.is_terminal or now - self.drawn < EVERY or not running:
            return
        self.drawn = now
        factor = statistics.median(self.ratios) if self.ratios else 1.
        left = sum(factor * job.seconds for job in waiting)
        left += sum(max(0., factor * job.seconds - (now - job.started) * job.case.ranks) for job in running)
        bar = "█" * (12 * self.done // self.n)
        text = (f"{self.study.name} {bar:░<12} {self.done} of {self.n} runs, about "
                f"{duration(left / self.cores)} left: {'; '.join(job.case.name for job in running)}")
        print(f"\r\033[K{text[:150]}", end="", flush=True)

    def close(self):
        """Leaves the terminal's line clean."""
        self._clear()

    def _clear(self):
        if self.is_terminal:
            print("\r\033[K", end="", flush=True)


def duration(seconds):
    """A time for people: 12 s, 3 min, 1.5 h."""
    if seconds < 100.:
        return f"{seconds:.2g} s" if seconds < 10. else f"{seconds:.0f} s"
    return f"{seconds / 60.:.0f} min" if seconds < 5400. else f"{seconds / 3600.:.1f} h"


def seconds(text):
    """Seconds of a time such as "20 min"."""
    number, unit = text.split()
    return float(number) * {"s": 1., "min": 60., "h": 3600.}[unit]
