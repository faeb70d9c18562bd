"""The generated formulas on a graphics processor: `python run.py bench --gpu`, where JAX, PyTorch or CuPy see one.

Absolute times, since there is nothing to take turns with, and the share of the bandwidth that a plain copy reaches:
FK moves 64 bytes a pose in float64, the four branches with their verdicts 168. Results are compared with NumPy first.
"""

import sys
import time

import numpy as np

import omx

ROWS, ROUNDS = 20_000_000, 7
WORK = {"pose": (omx.pose, 64), "four branches": (omx.ik_batch, 32 + 128 + 8)}


def jax():
    import jax

    jax.config.update("jax_enable_x64", True)
    if jax.default_backend() != "gpu":
        raise ImportError("JAX sees no graphics processor")
    put = jax.numpy.asarray
    return put, np.asarray, jax.jit, jax.block_until_ready, jax.jit(lambda a: a + 0.0)


def torch():
    import torch

    if not torch.cuda.is_available():
        raise ImportError("PyTorch sees no graphics processor")
    return (
        lambda a: torch.asarray(a, device="cuda"), lambda t: t.cpu().numpy(), None,
        lambda _: torch.cuda.synchronize(), torch.clone,
    )  # fmt: skip


def cupy():
    import cupy

    cupy.cuda.Device().use()
    return cupy.asarray, cupy.asnumpy, None, lambda _: cupy.cuda.Device().synchronize(), cupy.copy


def timed(call, argument, wait):
    """The shortest of some runs, after two that compile and warm up (s)."""
    spent = []
    for _ in range(ROUNDS + 2):
        start = time.perf_counter()
        wait(call(argument))
        spent.append(time.perf_counter() - start)
    return min(spent[2:])


def measure(library):
    """The lines of one library; raises `ImportError` where it is not, or sees no graphics processor."""
    put, back, compiled, wait, copy = library()
    rng = np.random.default_rng(1)
    few = rng.uniform(-1.4, 1.4, (1000, 4))
    q = put(rng.uniform(-1.4, 1.4, (ROWS, 4)))
    inputs = {"pose": q, "four branches": omx.pose(q)}
    np.testing.assert_allclose(back(omx.pose(put(few))), omx.pose(few), atol=1e-9)
    np.testing.assert_array_equal(back(omx.ik_batch(put(omx.pose(few)))[2]), omx.ik_batch(omx.pose(few))[2])
    bandwidth = 2 * 32 * ROWS / timed(copy, q, wait)
    yield f"copy of {ROWS:,} poses: {bandwidth / 1e12:.2f} TB/s"
    for name, (function, bytes_a_row) in WORK.items():
        ways = {"as written": function} | ({"compiled": compiled(function)} if compiled else {})
        for way, call in ways.items():
            seconds = timed(call, inputs[name], wait)
            share = bytes_a_row * ROWS / seconds / bandwidth
            yield f"{name}, {way}: {ROWS / seconds:.3g} rows/s, {share:.0%} of the copy's bandwidth"


def main() -> int:
    seen = 0
    for library in (jax, torch, cupy):
        try:
            for line in measure(library):
                print(f"{library.__name__:6} {line}", flush=True)
            seen += 1
        except ImportError as reason:
            print(f"{library.__name__:6} left out: {reason}")
        except Exception as error:  # one library that fails is no reason to leave out the others
            print(f"{library.__name__:6} failed: {type(error).__name__}: {str(error)[:300]}")
    return 0 if seen else 1


if __name__ == "__main__":
    sys.exit(main())
