"""A sweep by the workers of a scheduler of Dask: same bytes, whoever is killed, and what is wrong said in words."""

import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from threading import Event, Thread
from typing import Any

import pytest

import vibopt as vo
from vibopt.answer.jsonable import json_text
from vibopt.cli.main import main
from vibopt.cli.sweep_table import GrowingTable
from vibopt.errors import InputError, PoolError
from vibopt.study import cluster
from vibopt.study.sweep import sweep
from vibopt.study.workers import Processes, each

ROOT = Path(__file__).parents[2]
PUMP = ROOT / "problems" / "isolation" / "elastically_held_damper.toml"
HOLDER = "links.holder.stiffness"
WITHOUT = "import sys; sys.modules['vibopt'] = None; from distributed.cli.dask_worker import main; main()"
Process = subprocess.Popen[str]
Start = Callable[..., tuple[Process, str]]


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Start]:
    """Starts a scheduler or a worker of this machine, and waits until it says what it must."""
    pytest.importorskip("distributed", reason="distributed is not installed: pip install 'vibopt[cluster]'")
    begun: list[tuple[Process, Thread]] = []

    def started(*words: str, says: str) -> tuple[Process, str]:
        process = subprocess.Popen(
            [sys.executable, *words],
            stderr=subprocess.PIPE,
            text=True,
            cwd=tmp_path,
            env={**os.environ, "PYTHONPATH": str(ROOT), "PYTHONWARNINGS": "default"},
        )
        said, whole = Event(), []

        def read() -> None:
            assert process.stderr is not None
            with process.stderr as lines:
                for line in lines:
                    if says in line and not said.is_set():
                        whole.append(line.strip())
                        said.set()

        begun.append((process, Thread(target=read)))
        begun[-1][1].start()
        assert said.wait(60), f"{words} did not say {says}"
        return process, whole[0]

    yield started
    for process, reader in begun:
        process.kill()
        process.wait()
        reader.join()


def scheduler(start: Start) -> tuple[Process, str]:
    words = ("--host", "127.0.0.1", "--port", "0", "--no-dashboard")
    process, line = start("-m", "dask", "scheduler", *words, says="Scheduler at:")
    return process, line.split()[-1]


def worker(start: Start, address: str, *program: str) -> Process:
    words = (address, "--host", "127.0.0.1", "--no-dashboard", "--no-nanny", "--nthreads", "1")
    return start(*(program or ("-m", "dask", "worker")), *words, says="Registered to:")[0]


def test_one_of_two_workers_is_killed_and_then_the_scheduler(
    start: Start, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    process, address = scheduler(start)
    with ThreadPoolExecutor(2) as both:
        first, _ = both.map(lambda _: worker(start, address), range(2))
    job, told = vo.read(PUMP), []

    def third(_: object, point: object) -> None:
        told.append(point)
        if len(told) == 3:
            first.kill()

    words = (HOLDER, "-20 %..20 %", 24)
    one = sweep(job, *words)
    assert json_text(list(sweep(job, *words, cluster=address, answered=third).points)) == json_text(list(one.points))
    assert first.wait() == -signal.SIGKILL
    assert sorted(map(json_text, told)) == sorted(map(json_text, one.points))  # none is lost, none comes twice

    add = GrowingTable.add

    def stopping(what: Callable[[], object]) -> Callable[..., None]:
        def then(self: GrowingTable, *words: Any) -> None:
            add(self, *words)
            if len(self.points) == 5:
                what()

        return then

    out, whole = tmp_path / "out.csv", tmp_path / "whole.csv"
    typed = ["sweep", str(PUMP), "--vary", f"{HOLDER}=-20 %..20 %", "--points", "24", "--csv"]
    assert main([*typed, str(whole)]) == 0
    capsys.readouterr()
    shared = [*typed, str(out), "--cluster", address]
    goes_on = f"{out} holds 5 of 24 points; the same command with --resume goes on.\n"

    monkeypatch.setattr(GrowingTable, "add", stopping(lambda: signal.raise_signal(signal.SIGINT)))
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # in the background a shell has it ignored
    assert main(shared) == 130
    signal.signal(signal.SIGINT, before)
    assert capsys.readouterr().err.lstrip() == f"Stopped. {goes_on}"

    monkeypatch.setattr(GrowingTable, "add", stopping(lambda: (process.kill(), process.wait())))
    assert main(shared) == 1
    said = capsys.readouterr().err
    begins, _, count = said.partition(f" {out} holds ")
    assert begins == f"The scheduler at {address} went away."
    assert count in {f"{n} of 24 points; the same command with --resume goes on.\n" for n in range(5, 24)}
    assert len(out.read_text(encoding="utf-8").splitlines()) == 1 + int(count.split()[0])

    monkeypatch.setattr(GrowingTable, "add", add)
    assert main([*typed, str(out), "--resume"]) == 0
    assert out.read_bytes() == whole.read_bytes()


def refused(address: str) -> str:
    with pytest.raises(InputError) as error, cluster.cluster(address):
        pass
    return str(error.value)


def test_workers_that_would_answer_otherwise_are_refused(start: Start, monkeypatch: pytest.MonkeyPatch) -> None:
    _, address = scheduler(start)
    assert refused(address) == f"--cluster {address} has no worker. Start one, dask worker {address}."

    here = cluster.made_of()
    install = " ".join(f"'{name}=={one.split()[0]}'" for name, one in here.items() if name != "python")
    way = f"Install there what is here: pip install {install}."
    good = worker(start, address)
    monkeypatch.setattr(cluster, "made_of", lambda: {**here, "vibopt": "0.0.9 (12345678)", "numpy": "9.9"})
    begins, _, ends = refused(address).partition(": the worker tcp://127.0.0.1:")
    assert begins == f"--cluster {address}"
    numpy = f"has numpy {here['numpy']} in place of 9.9"
    vibopt = f"has vibopt {here['vibopt']} in place of 0.0.9 (12345678)"
    assert ends.partition(" ")[2].startswith(f"{vibopt} and {numpy}. Install there what is here: pip install 'vibopt==")
    monkeypatch.undo()

    with cluster.cluster(address) as pool:  # a worker that comes later is looked at too
        assert each(abs, [-1, 2], pool) == [1, 2]
        good.kill()
        worker(start, address, "-c", WITHOUT)
        with pytest.raises(PoolError, match="has no vibopt, or one that knows no cluster"):
            each(abs, [-1, 2], pool)
    ends = refused(address).partition(": the worker tcp://127.0.0.1:")[2]
    assert ends.partition(" ")[2] == f"has no vibopt, or one that knows no cluster. {way}"


NO_ADDRESS = " is no address. Write --cluster tcp://HOST:8786, as the scheduler says it."
NOBODY = (
    ": no scheduler of Dask answers there within 0.2 s. Start one, dask scheduler, and name the address that it says."
)


@pytest.mark.parametrize(
    ("address", "words"),
    [
        ("localhost", NO_ADDRESS),
        ("http://localhost:8786", NO_ADDRESS),
        ("tcp://127.0.0.1:1", NOBODY),
        ("127.0.0.1:99999", NOBODY),
    ],
)
def test_an_address_where_nobody_answers(address: str, words: str, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("distributed", reason="distributed is not installed: pip install 'vibopt[cluster]'")
    monkeypatch.setattr(cluster, "PATIENCE", 0.2)
    assert refused(address) == f"--cluster {address}{words}"


def test_without_dask(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    typed = ["sweep", str(PUMP), "--vary", f"{HOLDER}=-20 %..20 %", "--cluster", "tcp://127.0.0.1:1"]
    assert main(typed) == 2
    assert capsys.readouterr().err == (
        "--cluster needs distributed, which is not installed. Install it, pip install 'vibopt[cluster]', or take "
        "--workers 2: processes of this machine.\n"
    )
    assert main([*typed, "--workers", "2"]) == 2
    assert capsys.readouterr().err == "--workers and --cluster are both given. Leave one out.\n"


def test_a_time_limit_holds_in_every_process() -> None:
    from vibopt.work import each_answer_within

    job = vo.read(ROOT / "problems" / "absorbers" / "rao_9_57_tuned_freely.toml")
    path = "bodies.rotor.inertia"
    with each_answer_within(1e-6):
        one, two = (sweep(job, path, "-1 %..1 %", 2, workers=n) for n in (1, 2))
    assert [point.status for point in one.points] == [point.status for point in two.points] != ["optimal", "optimal"]


def test_lasting_processes_end_with_their_pool() -> None:
    with Processes(2, lasting=True) as pool:
        first = each(_pid, range(4), pool)
        assert len({*first}) <= 2
    for one in {*first}:
        assert isinstance(one, int)
        with pytest.raises(ProcessLookupError):
            os.kill(one, 0)


def _pid(_: int) -> int:
    return os.getpid()
