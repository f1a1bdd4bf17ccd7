"""What happens to a cluster at work, each as a function of a run of faults_test: it answers whether it found what it is about.
How long a restart or a freeze takes is part of its name."""
import os
import pathlib
import signal
import subprocess
import threading
import time

import program
from server_support import fill_disk, wait_until

AWAKE_AFTER_S = 18  # a lease lasts 15
LATE_S = 25  # longer than the store is waited for at first
SPOILT = 6  # answers
SMALL_DISK, FULL_S = "24m", 8


def kill(run):
    """A machine goes, with all that runs on it, and another comes."""
    run.kill(run.dice.choice(run.workers))
    run.start_worker()
    return True


def stop(run):
    """A worker sleeps beyond its lease and wakes among those that did its work."""
    worker = run.dice.choice(run.workers)
    worker.send_signal(signal.SIGSTOP)
    run.workers.remove(worker)
    run.stopped.append(worker)
    run.start_worker()
    threading.Timer(AWAKE_AFTER_S, worker.send_signal, (signal.SIGCONT,)).start()
    return True


def restart(seconds):
    def restart_database(run):
        run.database.stop(run.dice.choice((signal.SIGQUIT, signal.SIGINT)))
        time.sleep(seconds)
        run.database.start()
        return True
    return restart_database


def freeze_database(run):
    run.database.signal_all(signal.SIGSTOP)
    time.sleep(25)
    run.database.signal_all(signal.SIGCONT)
    return True


def cut_network(run):
    """Neither the database nor the store is heard of."""
    run.proxy.is_cut.set()
    run.database.stop(signal.SIGQUIT)
    time.sleep(20)
    run.database.start()
    run.proxy.is_cut.clear()
    return True


def cut_store(run):
    run.proxy.is_cut.set()
    time.sleep(12)
    run.proxy.is_cut.clear()
    return True


def slow_store(run):
    """What is put in these seconds is answered late."""
    run.proxy.slow_s = {"PUT": LATE_S, "POST": LATE_S, "GET": 2}
    time.sleep(6)
    run.proxy.slow_s = {}
    return True


def spoil_answers(run, spoil):
    """The next answers that have bytes, no object twice in a row: read again, it is right."""
    until = len(run.spoilt) + SPOILT

    def some(path, content):
        if len(run.spoilt) >= until or not content or path in run.spoilt[-3:] or "/skyquilt-data.json" in path:
            return content
        run.spoilt.append(path)
        return spoil(content)
    run.proxy.spoil = some
    return True


def flip_bytes(run):
    def flipped(content):
        at = run.dice.randrange(len(content))
        return content[:at] + bytes([content[at] ^ 0x40]) + content[at + 1:]
    return spoil_answers(run, flipped)


def cut_answers(run):
    """Some end half way, some say that they are shorter than they are."""
    return spoil_answers(run, lambda content: run.dice.choice((None, content[:-1])))


def small_disk(run):
    """The folder of a worker whose disk will be full; an ordinary one where no small disk can be mounted."""
    folder = run.folder_of_worker()
    os.mkdir(folder)
    mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={SMALL_DISK}", "tmpfs", folder], stderr=subprocess.DEVNULL)
    if mounted.returncode == 0:
        run.cleanups.append(lambda: subprocess.run(["umount", "-l", folder], check=True))
    run.small_disk = pathlib.Path(folder)
    return folder


def full_disk(run):
    """Of a worker at work, for a while. Where it is no small disk nothing can be written below the worker's folder of work."""
    work, others, aside = (run.small_disk / name for name in ("work", "others", "work-aside"))
    if os.path.ismount(run.small_disk):
        fill_disk(others)
        time.sleep(FULL_S)
        others.unlink()
    else:
        wait_until(work.is_dir, "the worker does not begin")
        work.rename(aside)
        work.write_text("nothing can be written below this")
        time.sleep(FULL_S)
        work.unlink()
        aside.rename(work)
    return True


def wrong_store(run):
    """Workers with a mistyped prefix, and with none: refused before they write or claim anything."""
    for blobs in (("--blobs", run.store.address(f"{run.name}-mistyped")), ()):
        folder = run.folder_of_worker()
        said = program.run("worker", "--once", "--data", folder, *run.catalogue, *blobs, code=None, timeout=240)
        run.expect(said.returncode == 1 and "--blobs" in said.stderr, f"a worker of another store: {said}")
        run.expect(not os.path.exists(folder), "a worker of another store left a folder")
    run.expect(run.store.keys(f"{run.name}-mistyped/") == [], "a worker of another store wrote into it")
    return True


def cancel(run):
    """The job is cancelled, and the next one makes the map."""
    status, answer = run.ask("DELETE", f"/api/v1/jobs/{run.job}")
    if status == 409:  # it had ended
        return False
    run.expect(status == 200, answer)
    run.expect(run.ended()["state"] == "dismissed", "a cancelled job is not dismissed")
    status, answer = run.ask("POST", f"/api/v1/flights/{run.flight}/jobs", {})
    run.expect(status == 202, answer)
    run.job = answer["id"]
    return True


def delete(run):
    """The flight goes for good, and is uploaded again."""
    run.expect(run.ask("DELETE", f"/api/v1/flights/{run.flight}")[0] == 204, "a flight is not deleted")
    status, answer = run.ask("DELETE", f"/api/v1/trash/{run.flight}")
    run.expect(status == 204, answer)
    run.gone.append(run.flight)
    run.upload()
    return True


KINDS = {
    "kill": kill, "stop": stop, "restart of 1 s": restart(1), "restart of 10 s": restart(10), "restart of 45 s": restart(45),
    "frozen database": freeze_database, "cut network": cut_network, "cut store": cut_store, "slow store": slow_store,
    "flipped bytes": flip_bytes, "short bytes": cut_answers, "full disk": full_disk, "wrong store": wrong_store,
    "cancel": cancel, "delete": delete}
# Each may take a worker with what it holds, which is one attempt of that.
OF_WORKERS = ("kill", "stop")
