"""Execution of tasks: in this process, others on this machine, or a cluster, with equal results."""

from __future__ import annotations

import itertools
import os
import signal
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, wait
from concurrent.futures.process import BrokenProcessPool
from typing import Any, Protocol, TypeAlias

import psutil

from camsim.core.cores import cores
from camsim.core.garbage import look_in_new
from camsim.core.kernels import use_one_thread
from camsim.core.typed import check
from camsim.errors import CamsimError, InvalidValueError
from camsim.files.describe import software
from camsim.study.manifest import Results


class Task(Protocol):
    """Work for a second or more."""

    @property
    def photosites(self) -> int:
        """Photosites of all its captures."""

    def carry_out(self) -> Results:
        """Run the task."""

    def given_up(self, why: str) -> Results:
        """Return the results of a task that could not be run."""


Engine: TypeAlias = Callable[[Iterable[Task]], Iterator[Results]]

ATTEMPTS = 3
"""Attempts of a task when workers die, so that one that kills workers does not stop the rest."""

_AHEAD = 2
"""Queued tasks per worker: more would only take memory."""

_SMALL = 5_000_000
"""Photosites times cores up to which workers would take longer to start than the captures."""

_LOOK_S = 0.5
"""Interval at which a worker checks that its parent process exists."""

_THREADS = ("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


def engine_of(workers: int | None, scheduler: str | None) -> Engine:
    """Return the requested engine: a cluster, this process (0), a number of processes, or what suits the tasks."""
    check(workers, int | None, "workers")
    check(scheduler, str | None, "scheduler")
    if scheduler is not None:
        if workers is not None:
            raise InvalidValueError("are the scheduler's; leave one of the two out", key="workers")
        return cluster(scheduler)
    if workers == 0:
        return here
    if workers is not None and workers < 0:
        raise InvalidValueError(f"{workers}; give 0 (this process) or more", key="workers")
    return processes(workers) if workers is not None else by_size


def here(tasks: Iterable[Task]) -> Iterator[Results]:
    """Carry tasks out in this process, one after another."""
    return map(_done, tasks)


def by_size(tasks: Iterable[Task]) -> Iterator[Results]:
    """Carry few small captures out in this process, and others on all cores."""
    each, workers = [*tasks], cores()
    small = workers * sum(task.photosites for task in each) <= _SMALL
    return (here if small else processes(workers))(each)


def _done(task: Task) -> Results:
    return task.carry_out()


def processes(workers: int) -> Engine:
    """Return an engine of processes on this machine, of one thread each: parallel over captures, not photosites."""

    def engine(tasks: Iterable[Task]) -> Iterator[Results]:
        from loky import ProcessPoolExecutor  # its workers do not run the user's script again

        waiting = [(task, 1) for task in tasks]
        waiting.reverse()
        while waiting:
            pool = ProcessPoolExecutor(workers, initializer=_begin_worker, env=dict.fromkeys(_THREADS, "1"))
            try:
                yield from _through(pool, waiting, _AHEAD * workers)
            finally:
                pool.shutdown(wait=True, kill_workers=True)

    return engine


def _through(pool: Any, waiting: list[tuple[Task, int]], most: int) -> Iterator[Results]:
    """Submit tasks to a pool until all are done or a worker has died; then those in flight are queued again."""
    flying: dict[Future[Results], tuple[Task, int]] = {}
    while waiting or flying:
        while waiting and len(flying) < most:
            task, attempt = waiting.pop()
            try:
                flying[pool.submit(_done, task)] = task, attempt
            except BrokenProcessPool:
                waiting.append((task, attempt))
                break
        if not flying:
            return
        done, _ = wait(flying, return_when=FIRST_COMPLETED)
        for future in done:
            task, attempt = flying.pop(future)
            error = future.exception()
            if error is None:
                yield future.result()
            elif not isinstance(error, BrokenProcessPool):
                raise error
            elif attempt < ATTEMPTS:
                waiting.append((task, attempt + 1))
            else:
                yield task.given_up("its worker died, three times")


def _begin_worker() -> None:
    """Restrict a worker to one core, and end it together with its parent process."""
    threading.Thread(target=_end_after, args=(os.getppid(),), daemon=True).start()
    look_in_new()
    _on_one_core()


def _end_after(process: int) -> None:
    """Wait for the end of a process, then end this one, which would otherwise hold its memory forever."""
    while os.getppid() == process and psutil.pid_exists(process):  # depending on the system, orphans are adopted or not
        time.sleep(_LOOK_S)
    os.kill(os.getpid(), signal.SIGTERM)


def _on_one_core() -> None:
    """Restrict a worker to one core, so that libraries start no further threads."""
    if not hasattr(os, "sched_setaffinity"):
        return
    mine = sorted(os.sched_getaffinity(0))
    os.sched_setaffinity(0, {mine[os.getpid() % len(mine)]})


def _done_on_one_core(task: Task) -> Results:
    """Carry out a task in a worker of a cluster, which has a core for each of its threads; dask sees to BLAS itself."""
    use_one_thread()
    return _done(task)


def _refuse_others(client: Any) -> None:
    """Raise CamsimError if a worker has another version of camsim, which could not read the tasks."""
    client.wait_for_workers(1)
    for address, its in sorted(client.run(software, on_error="return").items()):
        if its != software():
            has = f"has {its}" if isinstance(its, str) else f"cannot import camsim ({its})"
            raise CamsimError(f"the worker {address} {has}; install {software()} there")


def cluster(address: str) -> Engine:
    """Return an engine of the workers of a dask scheduler, such as tcp://192.168.0.1:8786."""
    try:
        from distributed import Client, as_completed
    except ImportError:
        raise InvalidValueError("needs dask: pip install 'camsim-spectral[cluster]'", key="--scheduler") from None

    def engine(tasks: Iterable[Task]) -> Iterator[Results]:
        try:
            client = Client(address, timeout=10)
        except (OSError, ValueError, TimeoutError) as error:
            raise InvalidValueError(f"no scheduler at {address!r}: {error}", key="--scheduler") from None
        with client:
            _refuse_others(client)
            most = _AHEAD * max(1, sum(client.ncores().values()))
            left = iter(tasks)
            flying = as_completed(with_results=False)
            of: dict[Any, Task] = {}
            what = f"the scheduler at {address} is lost; what is finished is kept, sweep again to go on"
            lost = ConnectionError(what)

            def hand_out(count: int) -> None:
                if client.status == "closed":
                    raise lost
                for task in itertools.islice(left, count):
                    future = client.submit(_done_on_one_core, task, pure=False, retries=ATTEMPTS)
                    of[future.key] = task
                    flying.add(future)

            hand_out(most)
            for future in flying:
                task = of.pop(future.key)
                if future.cancelled():  # only cancelled here
                    raise lost
                failure = future.exception()
                if failure is None:
                    try:
                        results = future.result()  # queries the scheduler
                    except (OSError, CancelledError) as error:
                        raise lost from error
                    yield results
                elif isinstance(failure, CamsimError):
                    raise failure
                else:
                    yield task.given_up(f"{type(failure).__name__}: {failure}")
                hand_out(1)

    return engine
