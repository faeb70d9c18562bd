"""Another process: what comes back from one is a copy that shares nothing with what went in."""

import copy
import multiprocessing
from concurrent.futures import ProcessPoolExecutor


def pool() -> ProcessPoolExecutor:
    """One process, started anew, as it is on every system."""
    return ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn"))


def there_and_back(things) -> list:
    """Each of these after a trip through a process of a pool."""
    with pool() as executor:
        return executor.submit(copy.copy, list(things)).result(timeout=60)
