"""Other people's kinematics, each measured in its own process against ours: what they are and where they live."""

from typing import NamedTuple


class Peer(NamedTuple):
    """`module` in this folder measures it, with the Python of `environment`.

    `environment`: a line `#: NAME ...` of environment.txt, or "", the book's own. `packages`: whose versions the
    report names. `runs`: numbers of processors to start it with, a process for each; 0 is all of them.
    """

    module: str
    environment: str
    packages: tuple[str, ...]
    runs: tuple[int, ...] = (0,)


#: By the name that `python -m tests.bench.peer NAME` takes.
PEERS = {
    "omx": Peer("own", "fast", ("numpy", "numba", "cffi")),
    "pinocchio": Peer("pinocchio_loop", "", ("pin",)),
    "roboticstoolbox": Peer("toolbox", "peer-toolbox", ("roboticstoolbox-python", "spatialmath-python")),
    "ikpy": Peer("ikpy_chain", "peer-ikpy", ("ikpy",)),
    "EAIK": Peer("eaik_arm", "peer-eaik", ("EAIK",)),
    "ssik": Peer("ssik_arm", "peer-ssik", ("ssik",)),
    "jax": Peer("jax_formulas", "peer-jax", ("jax", "jaxlib"), (1, 2)),
}
